// human: the person who assembles the table, and whose actions are the abstract test.
//
// Beliefs that meta chooses from:
//   leg1 .. leg4        the leg to begin with: from leg1 on the human wants four legs, from leg4 on one;
//   bored, not_bored    whether it waits for the first leg; without either it is not bored;
//   m000l1 .. m111l4    the pose for a leg: gaze, pressure and location wanted (1: as if ready), leg 1 to 4.
// While it works, the human believes legK for the leg that it is at.
//
// What the human does to the world are external actions; what it says to the robot it also sends
// to the agent robot_code, and what its pose is to the agent sensors. It sends a request only once it
// listens for the answer, so that no answer can come too early.

// --- ask for a leg

@plan1 +!request : leg1
   <- tell(leg);
      receivesignal;
      !wait_for_leg.

@plan2 +!request : leg2
   <- tell(leg);
      receivesignal;
      !wait_for_leg.

@plan3 +!request : leg3
   <- tell(leg);
      receivesignal;
      !wait_for_leg.

@plan4 +!request : leg4
   <- tell(leg);
      receivesignal;
      !wait_for_leg.

// No leg to begin with: nothing to do.
+!request.

// --- wait until the robot says that the leg is ready

// Patiently.
@plan5 +!wait_for_leg : not bored
   <- .send(robot_code, tell, leg_wanted).

// The robot says that the leg is ready.
@plan6 +leg_ready[source(robot_code)] : not away
   <- -leg_ready[source(robot_code)];
      !turn_to_leg.

// Bored: the human walks off and hears nothing, so the robot will time out and discard the leg.
// meta gave this belief, and it holds for one leg only: it goes with the source it came with.
@plan7 +!wait_for_leg : bored
   <- +away;
      .send(robot_code, tell, leg_wanted);
      bored;
      -bored[source(meta)].

// Turn to the leg and take the pose for it.
@plan8 +!turn_to_leg
   <- !take_pose.

// Who is away does not hear the robot.
+leg_ready[source(robot_code)]
   <- -leg_ready[source(robot_code)].

// --- the pose: location, pressure, gaze; the first one believed for the leg

@plan9 +!take_pose : leg1 & m000l1
   <- set_param(location, 0); set_param(pressure, 0); set_param(gaze, 0);
      .send(sensors, tell, pose(0, 0, 0));
      !say_ready.

@plan10 +!take_pose : leg1 & m001l1
   <- set_param(location, 1); set_param(pressure, 0); set_param(gaze, 0);
      .send(sensors, tell, pose(0, 0, 1));
      !say_ready.

@plan11 +!take_pose : leg1 & m010l1
   <- set_param(location, 0); set_param(pressure, 1); set_param(gaze, 0);
      .send(sensors, tell, pose(0, 1, 0));
      !say_ready.

@plan12 +!take_pose : leg1 & m011l1
   <- set_param(location, 1); set_param(pressure, 1); set_param(gaze, 0);
      .send(sensors, tell, pose(0, 1, 1));
      !say_ready.

@plan13 +!take_pose : leg1 & m100l1
   <- set_param(location, 0); set_param(pressure, 0); set_param(gaze, 1);
      .send(sensors, tell, pose(1, 0, 0));
      !say_ready.

@plan14 +!take_pose : leg1 & m101l1
   <- set_param(location, 1); set_param(pressure, 0); set_param(gaze, 1);
      .send(sensors, tell, pose(1, 0, 1));
      !say_ready.

@plan15 +!take_pose : leg1 & m110l1
   <- set_param(location, 0); set_param(pressure, 1); set_param(gaze, 1);
      .send(sensors, tell, pose(1, 1, 0));
      !say_ready.

@plan16 +!take_pose : leg1 & m111l1
   <- set_param(location, 1); set_param(pressure, 1); set_param(gaze, 1);
      .send(sensors, tell, pose(1, 1, 1));
      !say_ready.

@plan17 +!take_pose : leg2 & m000l2
   <- set_param(location, 0); set_param(pressure, 0); set_param(gaze, 0);
      .send(sensors, tell, pose(0, 0, 0));
      !say_ready.

@plan18 +!take_pose : leg2 & m001l2
   <- set_param(location, 1); set_param(pressure, 0); set_param(gaze, 0);
      .send(sensors, tell, pose(0, 0, 1));
      !say_ready.

@plan19 +!take_pose : leg2 & m010l2
   <- set_param(location, 0); set_param(pressure, 1); set_param(gaze, 0);
      .send(sensors, tell, pose(0, 1, 0));
      !say_ready.

@plan20 +!take_pose : leg2 & m011l2
   <- set_param(location, 1); set_param(pressure, 1); set_param(gaze, 0);
      .send(sensors, tell, pose(0, 1, 1));
      !say_ready.

@plan21 +!take_pose : leg2 & m100l2
   <- set_param(location, 0); set_param(pressure, 0); set_param(gaze, 1);
      .send(sensors, tell, pose(1, 0, 0));
      !say_ready.

@plan22 +!take_pose : leg2 & m101l2
   <- set_param(location, 1); set_param(pressure, 0); set_param(gaze, 1);
      .send(sensors, tell, pose(1, 0, 1));
      !say_ready.

@plan23 +!take_pose : leg2 & m110l2
   <- set_param(location, 0); set_param(pressure, 1); set_param(gaze, 1);
      .send(sensors, tell, pose(1, 1, 0));
      !say_ready.

@plan24 +!take_pose : leg2 & m111l2
   <- set_param(location, 1); set_param(pressure, 1); set_param(gaze, 1);
      .send(sensors, tell, pose(1, 1, 1));
      !say_ready.

@plan25 +!take_pose : leg3 & m000l3
   <- set_param(location, 0); set_param(pressure, 0); set_param(gaze, 0);
      .send(sensors, tell, pose(0, 0, 0));
      !say_ready.

@plan26 +!take_pose : leg3 & m001l3
   <- set_param(location, 1); set_param(pressure, 0); set_param(gaze, 0);
      .send(sensors, tell, pose(0, 0, 1));
      !say_ready.

@plan27 +!take_pose : leg3 & m010l3
   <- set_param(location, 0); set_param(pressure, 1); set_param(gaze, 0);
      .send(sensors, tell, pose(0, 1, 0));
      !say_ready.

@plan28 +!take_pose : leg3 & m011l3
   <- set_param(location, 1); set_param(pressure, 1); set_param(gaze, 0);
      .send(sensors, tell, pose(0, 1, 1));
      !say_ready.

@plan29 +!take_pose : leg3 & m100l3
   <- set_param(location, 0); set_param(pressure, 0); set_param(gaze, 1);
      .send(sensors, tell, pose(1, 0, 0));
      !say_ready.

@plan30 +!take_pose : leg3 & m101l3
   <- set_param(location, 1); set_param(pressure, 0); set_param(gaze, 1);
      .send(sensors, tell, pose(1, 0, 1));
      !say_ready.

@plan31 +!take_pose : leg3 & m110l3
   <- set_param(location, 0); set_param(pressure, 1); set_param(gaze, 1);
      .send(sensors, tell, pose(1, 1, 0));
      !say_ready.

@plan32 +!take_pose : leg3 & m111l3
   <- set_param(location, 1); set_param(pressure, 1); set_param(gaze, 1);
      .send(sensors, tell, pose(1, 1, 1));
      !say_ready.

@plan33 +!take_pose : leg4 & m000l4
   <- set_param(location, 0); set_param(pressure, 0); set_param(gaze, 0);
      .send(sensors, tell, pose(0, 0, 0));
      !say_ready.

@plan34 +!take_pose : leg4 & m001l4
   <- set_param(location, 1); set_param(pressure, 0); set_param(gaze, 0);
      .send(sensors, tell, pose(0, 0, 1));
      !say_ready.

@plan35 +!take_pose : leg4 & m010l4
   <- set_param(location, 0); set_param(pressure, 1); set_param(gaze, 0);
      .send(sensors, tell, pose(0, 1, 0));
      !say_ready.

@plan36 +!take_pose : leg4 & m011l4
   <- set_param(location, 1); set_param(pressure, 1); set_param(gaze, 0);
      .send(sensors, tell, pose(0, 1, 1));
      !say_ready.

@plan37 +!take_pose : leg4 & m100l4
   <- set_param(location, 0); set_param(pressure, 0); set_param(gaze, 1);
      .send(sensors, tell, pose(1, 0, 0));
      !say_ready.

@plan38 +!take_pose : leg4 & m101l4
   <- set_param(location, 1); set_param(pressure, 0); set_param(gaze, 1);
      .send(sensors, tell, pose(1, 0, 1));
      !say_ready.

@plan39 +!take_pose : leg4 & m110l4
   <- set_param(location, 0); set_param(pressure, 1); set_param(gaze, 1);
      .send(sensors, tell, pose(1, 1, 0));
      !say_ready.

@plan40 +!take_pose : leg4 & m111l4
   <- set_param(location, 1); set_param(pressure, 1); set_param(gaze, 1);
      .send(sensors, tell, pose(1, 1, 1));
      !say_ready.

// No pose for this leg: the human does not get ready, and the robot will discard the leg.
+!take_pose.

// --- say ready, and hear what becomes of the leg

@plan41 +!say_ready
   <- tell(humanReady);
      !wait_for_outcome.

@plan42 +!wait_for_outcome
   <- .send(robot_code, tell, human_ready).

// Not released: the turn is lost, on to the next leg.
@plan43 +leg_discarded[source(robot_code)] : not away
   <- -leg_discarded[source(robot_code)];
      !go_on.

@plan44 +leg_released[source(robot_code)]
   <- -leg_released[source(robot_code)];
      !go_on.

// Back from being bored: a leg that was discarded meanwhile does not count, so it asks for it again.
+leg_discarded[source(robot_code)]
   <- -leg_discarded[source(robot_code)];
      -away;
      !request.

// --- on to the next leg
// The leg to begin with came from meta, those after it are the human's own idea: all sources go.

@plan45 +!go_on : leg1
   <- .abolish(leg1);
      +leg2;
      !request.

@plan46 +!go_on : leg2
   <- .abolish(leg2);
      +leg3;
      !request.

@plan47 +!go_on : leg3
   <- .abolish(leg3);
      +leg4;
      !request.

// The table is done.
@plan48 +!go_on : leg4
   <- .abolish(leg4).
