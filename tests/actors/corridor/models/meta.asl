// Gives each person what was chosen for them; a belief that is none of theirs changes nothing.
// lint: percepts chosen
!steer.

+!steer
   <- for (chosen(Belief)) { .send(nurse, tell, Belief); .send(child, tell, Belief) };
      .send(nurse, achieve, work);
      .send(child, achieve, play).
