// sensors: gaze, pressure and location, computed from the pose that the human has taken.
//
// A pose holds for one leg: it is forgotten when the robot has asked for it.

// Nobody in view: looks away, does not pull, hand far from the leg. There is nothing to
// report, and the robot will have to notice by itself that no reading comes.
+reading_wanted[source(robot_code)] : pose(0, 0, 0)
   <- -reading_wanted[source(robot_code)];
      -pose(0, 0, 0)[source(human)].

+reading_wanted[source(robot_code)] : pose(Gaze, Pressure, Location)
   <- -reading_wanted[source(robot_code)];
      -pose(Gaze, Pressure, Location)[source(human)];
      .send(robot_code, tell, reading(Gaze, Pressure, Location)).

// Asked before any pose was taken: as if nobody were in view.
+reading_wanted[source(robot_code)]
   <- -reading_wanted[source(robot_code)].
