// lint: percepts chosen
!steer.
+!steer <- for (chosen(B)) { .send(person, tell, B) }; .send(person, achieve, visit).
