// robot_code: the control code of the robot as an agent, one plan for each of its states.
//
// The robot keeps time itself. The belief clock(S) is how many seconds it has spent on the leg at
// hand: each thing it does adds its duration. listening_since(S) is when it began to wait, for the
// human or for the sensors; how long it waits at most are the beliefs below. The legs of a table
// are counted by turns(N), handed over or not.
//
// Each run of the real code is compared with this agent, too (MODEL in the reports). Its actions are for that: what the
// robot is seen to do. An action that fails is seen to fail. In such a run, the limits below are those of the real code.

patience_for_human(60).     // s, until the human says that it is ready
patience_for_sensors(40).   // s, until a reading comes
listening_step(20).         // s, after which it looks at its clock while it waits for the human
sensing_step(20).           // s, the same while it waits for the sensors

!reset.

// --- reset, and requests

// All counters to zero: the next table begins. What stands between two tables is the request.
@p1 +!reset
   <- -+clock(0);
      -+turns(0).

// At work it does not listen: a request that comes now does not count.
+leg_wanted[source(human)] : at_work
   <- -leg_wanted[source(human)].

// Receive1: the human wants a leg.
@p2 +leg_wanted[source(human)]
   <- -leg_wanted[source(human)];
      +at_work;
      -+outcome(discarded);
      !fetch.

// --- to the handover place

// Move_hand: plan, reach, close the hand, lift, bring.
@p3 +!fetch : clock(S)
   <- -+clock(S + 30);
      !grasp(1);
      !announce.

// The hand is closed twice at most.
+!grasp(Attempt)
   <- close_hand;
      hold_leg.
-!grasp(1)
   <- !grasp(2).
-!grasp(2)
   <- +empty_handed.

// No leg, so there is none to announce.
+!announce : empty_handed
   <- !discard.

// Send1: tell the human that the leg is ready, and listen.
// Who said "ready" before has to say it again.
@p4 +!announce : clock(S)
   <- -+clock(S + 2);
      -+listening_since(S + 2);
      ?turns(N);
      offer(N + 1);
      .send(human, tell, leg_ready);
      .abolish(human_ready);
      !hear_ready.

// --- Receive2: wait for the human

@p5 +!hear_ready : human_ready[source(human)] & clock(S)
   <- -human_ready[source(human)];
      -+clock(S + 2);
      -+listening_since(S + 2);
      .send(sensors, tell, reading_wanted);
      !sense.

// Timeout2: the human does not say that it is ready.
@p6 +!hear_ready : clock(S) & listening_since(Since) & patience_for_human(Limit) & S - Since >= Limit
   <- -+outcome("no-human-ready");
      !discard.

// Not yet: listen for another twenty seconds. (A second is a millisecond for the agents.)
+!hear_ready : clock(S)
   <- ?listening_step(Step);
      .wait(human_ready[source(human)], Step, _);
      -+clock(S + Step);
      !hear_ready.

// --- Sensing and Decide

// Timeout3: no reading came.
@p7 +!sense : not reading(_, _, _)
            & clock(S) & listening_since(Since) & patience_for_sensors(Limit) & S - Since >= Limit
   <- -+outcome("sensing-timeout");
      !discard.

@p8 +!sense : reading(Gaze, Pressure, Location)[source(sensors)]
   <- -reading(Gaze, Pressure, Location)[source(sensors)];
      !decide(Gaze, Pressure, Location).

+!sense : clock(S)
   <- ?sensing_step(Step);
      .wait(reading(_, _, _)[source(sensors)], Step, _);
      -+clock(S + Step);
      !sense.

// The human is not ready: some sensor does not say so.
@p9 +!decide(Gaze, Pressure, Location) : not (Gaze == 1 & Pressure == 1 & Location == 1)
   <- !discard.

// The human is ready: open the hand.
@p10 +!decide(1, 1, 1)
   <- -+outcome(released);
      release;
      !leg_done(leg_released).

// --- the end of a turn

// A turn is over: the clock starts anew for the next leg, and with four turns the table is done.
// The human hears of it last, so that its next request finds the robot ready to receive.
@p11 +!leg_done(Outcome) : turns(N)
   <- -+turns(N + 1);
      -+clock(0);
      if (N == 3) { !reset };
      ?outcome(Reported);
      report_turn(N + 1, Reported);
      .send(human, tell, Outcome);
      if (N == 3) { report_table };
      -at_work.

// Discard: open away from the human. A "ready" that came too late is not for the next leg.
@p12 +!discard
   <- .abolish(human_ready);
      !drop_leg;
      !leg_done(leg_discarded).

+!drop_leg : empty_handed
   <- -empty_handed.
+!drop_leg
   <- drop.
