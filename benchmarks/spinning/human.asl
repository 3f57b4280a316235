// human of the table assembly, written the way many wait in AgentSpeak: by looking again and again.

@plan1 +!request : leg1 <- tell(leg); .send(robot_code, tell, leg_wanted); receivesignal; !wait_for_leg.
@plan2 +!request : leg2 <- tell(leg); .send(robot_code, tell, leg_wanted); receivesignal; !wait_for_leg.
@plan3 +!request : leg3 <- tell(leg); .send(robot_code, tell, leg_wanted); receivesignal; !wait_for_leg.
@plan4 +!request : leg4 <- tell(leg); .send(robot_code, tell, leg_wanted); receivesignal; !wait_for_leg.
+!request.

@plan5 +!wait_for_leg : not leg_ready & not bored <- !wait_for_leg.
@plan6 +!wait_for_leg : leg_ready <- -leg_ready[source(robot_code)]; !take_pose.
@plan7 +!wait_for_leg : bored <- bored; -bored[source(meta)]; !wait_for_outcome.

@plan9 +!take_pose : leg1 & m000l1
   <- set_param(location, 0); set_param(pressure, 0); set_param(gaze, 0); .send(sensors, tell, pose000); !say_ready.
@plan10 +!take_pose : leg1 & m001l1
   <- set_param(location, 1); set_param(pressure, 0); set_param(gaze, 0); .send(sensors, tell, pose001); !say_ready.
@plan11 +!take_pose : leg1 & m010l1
   <- set_param(location, 0); set_param(pressure, 1); set_param(gaze, 0); .send(sensors, tell, pose010); !say_ready.
@plan12 +!take_pose : leg1 & m011l1
   <- set_param(location, 1); set_param(pressure, 1); set_param(gaze, 0); .send(sensors, tell, pose011); !say_ready.
@plan13 +!take_pose : leg1 & m100l1
   <- set_param(location, 0); set_param(pressure, 0); set_param(gaze, 1); .send(sensors, tell, pose100); !say_ready.
@plan14 +!take_pose : leg1 & m101l1
   <- set_param(location, 1); set_param(pressure, 0); set_param(gaze, 1); .send(sensors, tell, pose101); !say_ready.
@plan15 +!take_pose : leg1 & m110l1
   <- set_param(location, 0); set_param(pressure, 1); set_param(gaze, 1); .send(sensors, tell, pose110); !say_ready.
@plan16 +!take_pose : leg1 & m111l1
   <- set_param(location, 1); set_param(pressure, 1); set_param(gaze, 1); .send(sensors, tell, pose111); !say_ready.
@plan17 +!take_pose : leg2 & m000l2
   <- set_param(location, 0); set_param(pressure, 0); set_param(gaze, 0); .send(sensors, tell, pose000); !say_ready.
@plan18 +!take_pose : leg2 & m001l2
   <- set_param(location, 1); set_param(pressure, 0); set_param(gaze, 0); .send(sensors, tell, pose001); !say_ready.
@plan19 +!take_pose : leg2 & m010l2
   <- set_param(location, 0); set_param(pressure, 1); set_param(gaze, 0); .send(sensors, tell, pose010); !say_ready.
@plan20 +!take_pose : leg2 & m011l2
   <- set_param(location, 1); set_param(pressure, 1); set_param(gaze, 0); .send(sensors, tell, pose011); !say_ready.
@plan21 +!take_pose : leg2 & m100l2
   <- set_param(location, 0); set_param(pressure, 0); set_param(gaze, 1); .send(sensors, tell, pose100); !say_ready.
@plan22 +!take_pose : leg2 & m101l2
   <- set_param(location, 1); set_param(pressure, 0); set_param(gaze, 1); .send(sensors, tell, pose101); !say_ready.
@plan23 +!take_pose : leg2 & m110l2
   <- set_param(location, 0); set_param(pressure, 1); set_param(gaze, 1); .send(sensors, tell, pose110); !say_ready.
@plan24 +!take_pose : leg2 & m111l2
   <- set_param(location, 1); set_param(pressure, 1); set_param(gaze, 1); .send(sensors, tell, pose111); !say_ready.
@plan25 +!take_pose : leg3 & m000l3
   <- set_param(location, 0); set_param(pressure, 0); set_param(gaze, 0); .send(sensors, tell, pose000); !say_ready.
@plan26 +!take_pose : leg3 & m001l3
   <- set_param(location, 1); set_param(pressure, 0); set_param(gaze, 0); .send(sensors, tell, pose001); !say_ready.
@plan27 +!take_pose : leg3 & m010l3
   <- set_param(location, 0); set_param(pressure, 1); set_param(gaze, 0); .send(sensors, tell, pose010); !say_ready.
@plan28 +!take_pose : leg3 & m011l3
   <- set_param(location, 1); set_param(pressure, 1); set_param(gaze, 0); .send(sensors, tell, pose011); !say_ready.
@plan29 +!take_pose : leg3 & m100l3
   <- set_param(location, 0); set_param(pressure, 0); set_param(gaze, 1); .send(sensors, tell, pose100); !say_ready.
@plan30 +!take_pose : leg3 & m101l3
   <- set_param(location, 1); set_param(pressure, 0); set_param(gaze, 1); .send(sensors, tell, pose101); !say_ready.
@plan31 +!take_pose : leg3 & m110l3
   <- set_param(location, 0); set_param(pressure, 1); set_param(gaze, 1); .send(sensors, tell, pose110); !say_ready.
@plan32 +!take_pose : leg3 & m111l3
   <- set_param(location, 1); set_param(pressure, 1); set_param(gaze, 1); .send(sensors, tell, pose111); !say_ready.
@plan33 +!take_pose : leg4 & m000l4
   <- set_param(location, 0); set_param(pressure, 0); set_param(gaze, 0); .send(sensors, tell, pose000); !say_ready.
@plan34 +!take_pose : leg4 & m001l4
   <- set_param(location, 1); set_param(pressure, 0); set_param(gaze, 0); .send(sensors, tell, pose001); !say_ready.
@plan35 +!take_pose : leg4 & m010l4
   <- set_param(location, 0); set_param(pressure, 1); set_param(gaze, 0); .send(sensors, tell, pose010); !say_ready.
@plan36 +!take_pose : leg4 & m011l4
   <- set_param(location, 1); set_param(pressure, 1); set_param(gaze, 0); .send(sensors, tell, pose011); !say_ready.
@plan37 +!take_pose : leg4 & m100l4
   <- set_param(location, 0); set_param(pressure, 0); set_param(gaze, 1); .send(sensors, tell, pose100); !say_ready.
@plan38 +!take_pose : leg4 & m101l4
   <- set_param(location, 1); set_param(pressure, 0); set_param(gaze, 1); .send(sensors, tell, pose101); !say_ready.
@plan39 +!take_pose : leg4 & m110l4
   <- set_param(location, 0); set_param(pressure, 1); set_param(gaze, 1); .send(sensors, tell, pose110); !say_ready.
@plan40 +!take_pose : leg4 & m111l4
   <- set_param(location, 1); set_param(pressure, 1); set_param(gaze, 1); .send(sensors, tell, pose111); !say_ready.
+!take_pose <- !wait_for_outcome.

@plan41 +!say_ready <- tell(humanReady); .send(robot_code, tell, human_ready); !wait_for_outcome.

@plan42 +!wait_for_outcome : not leg_released & not leg_discarded <- !wait_for_outcome.
@plan43 +!wait_for_outcome : leg_discarded <- -leg_discarded[source(robot_code)]; !go_on.
@plan44 +!wait_for_outcome : leg_released <- -leg_released[source(robot_code)]; !go_on.

@plan45 +!go_on : leg1 <- .abolish(leg1); +leg2; !request.
@plan46 +!go_on : leg2 <- .abolish(leg2); +leg3; !request.
@plan47 +!go_on : leg3 <- .abolish(leg3); +leg4; !request.
@plan48 +!go_on : leg4 <- .abolish(leg4).
