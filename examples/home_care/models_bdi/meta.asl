// meta: steers the person and the dog by the beliefs that were chosen for them.
//
// It perceives chosen(B) for each of them and gives B to both: a belief that is none of theirs changes nothing. Only
// then it lets the person begin, so that the order in which they were chosen makes no difference.
// lint: percepts chosen

!steer.

+!steer
   <- for (chosen(B)) { .send(person, tell, B); .send(dog, tell, B) };
      .send(person, achieve, live).
