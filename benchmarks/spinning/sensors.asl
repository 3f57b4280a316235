// sensors of the table assembly: they look again and again whether a reading is wanted.

!sense.

+!sense : not reading_wanted <- !sense.
+!sense : reading_wanted & pose000
   <- -reading_wanted[source(robot_code)]; -pose000[source(human)]; .send(robot_code, tell, reading000); !sense.
+!sense : reading_wanted & pose001
   <- -reading_wanted[source(robot_code)]; -pose001[source(human)]; .send(robot_code, tell, reading001); !sense.
+!sense : reading_wanted & pose010
   <- -reading_wanted[source(robot_code)]; -pose010[source(human)]; .send(robot_code, tell, reading010); !sense.
+!sense : reading_wanted & pose011
   <- -reading_wanted[source(robot_code)]; -pose011[source(human)]; .send(robot_code, tell, reading011); !sense.
+!sense : reading_wanted & pose100
   <- -reading_wanted[source(robot_code)]; -pose100[source(human)]; .send(robot_code, tell, reading100); !sense.
+!sense : reading_wanted & pose101
   <- -reading_wanted[source(robot_code)]; -pose101[source(human)]; .send(robot_code, tell, reading101); !sense.
+!sense : reading_wanted & pose110
   <- -reading_wanted[source(robot_code)]; -pose110[source(human)]; .send(robot_code, tell, reading110); !sense.
+!sense : reading_wanted & pose111
   <- -reading_wanted[source(robot_code)]; -pose111[source(human)]; .send(robot_code, tell, reading111); !sense.
