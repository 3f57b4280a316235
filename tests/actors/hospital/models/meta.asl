// Gives each person what was chosen for them, and lets all begin.
// lint: percepts chosen
!steer.

+!steer
   <- for (chosen(Belief)) {
         .send(nurse, tell, Belief); .send(porter, tell, Belief); .send(child, tell, Belief)
      };
      .send(nurse, achieve, deliver);
      .send(porter, achieve, serve);
      .send(child, achieve, play).
