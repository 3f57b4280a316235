// robot_code of the table assembly, without a sense of time: it looks again and again.

!reset.

@p1 +!reset <- +turn1; !receive.

+!receive : not leg_wanted <- !receive.
@p2 +!receive <- -leg_wanted[source(human)]; !fetch.
@p3 +!fetch <- !announce.
@p4 +!announce <- .send(human, tell, leg_ready); !hear_ready.

+!hear_ready : not human_ready <- !hear_ready.
@p5 +!hear_ready <- -human_ready[source(human)]; .send(sensors, tell, reading_wanted); !sense.

@p8_000 +!sense : reading000 <- -reading000[source(sensors)]; !discard.
@p8_001 +!sense : reading001 <- -reading001[source(sensors)]; !discard.
@p8_010 +!sense : reading010 <- -reading010[source(sensors)]; !discard.
@p8_011 +!sense : reading011 <- -reading011[source(sensors)]; !discard.
@p8_100 +!sense : reading100 <- -reading100[source(sensors)]; !discard.
@p8_101 +!sense : reading101 <- -reading101[source(sensors)]; !discard.
@p8_110 +!sense : reading110 <- -reading110[source(sensors)]; !discard.
@p8_111 +!sense : reading111 <- -reading111[source(sensors)]; !release.
+!sense <- !sense.

@p10 +!release <- .send(human, tell, leg_released); !leg_done.
@p12 +!discard <- .send(human, tell, leg_discarded); !leg_done.

+!leg_done : turn1 <- -turn1; +turn2; !receive.
+!leg_done : turn2 <- -turn2; +turn3; !receive.
+!leg_done : turn3 <- -turn3; +turn4; !receive.
+!leg_done.
