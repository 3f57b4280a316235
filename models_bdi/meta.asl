// meta: steers the human by the beliefs that were chosen for it.
//
// It perceives chosen(B) for each of them, gives them to the human, and only then lets it begin,
// so that the order in which they were chosen makes no difference.
// lint: percepts chosen

!steer.

+!steer
   <- for (chosen(B)) { .send(human, tell, B) };
      .send(human, achieve, request).
