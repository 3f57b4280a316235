// dog: lies in the living room, or follows the robot when it comes by, until the person calls it.
//
// Beliefs that meta chooses from: dog_follows, without which it lies.

// The robot passes, and the dog goes with it: right in front of the laser.
@follows +passing[source(robot)] : dog_follows & not called
   <- -passing[source(robot)];
      .send(sensors, tell, dog_near).

@lies +passing[source(robot)]
   <- -passing[source(robot)].

// Called: it comes to the person, and stays there.
@obeys +called[source(person)]
   <- .send(sensors, untell, dog_near).
