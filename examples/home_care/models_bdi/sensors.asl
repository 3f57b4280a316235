// sensors: whether somebody is in the robot's way, as its laser sees it.
//
// driving(P) is where the robot says that it drives to; person_at(P) where the person stands, and dog_near that the dog
// walks in front of the robot. The robot hears only of a change: obstructed, where it can drive around somebody, and
// blocked, where it cannot; or no longer.

passes(fridge, kitchen).    // on the way there it comes by; at its goal somebody is in its way anyhow
passes(sink, kitchen).
passes(charger, kitchen).
passes(table, doorway).

@sees_at_goal +driving(Place)[source(robot)] : person_at(Place)
   <- .send(robot, tell, blocked).

@sees_on_way +driving(Place)[source(robot)] : person_at(On) & passes(Place, On)
   <- .send(robot, tell, obstructed).

@sees_dog +driving(_)[source(robot)] : dog_near
   <- .send(robot, tell, blocked).

@comes_to_goal +person_at(Place)[source(person)] : driving(Place)
   <- .send(robot, tell, blocked).

@comes_on_way +person_at(On)[source(person)] : driving(Place) & passes(Place, On)
   <- .send(robot, tell, obstructed).

@person_leaves -person_at(_)[source(person)]
   <- .send(robot, untell, blocked);
      .send(robot, untell, obstructed).

@dog_leaves -dog_near[source(dog)]
   <- .send(robot, untell, blocked).
