// The steering agent: hands the chosen beliefs to all people.
// lint: percepts chosen
!steer.
+!steer <- for (chosen(B)) { .broadcast(tell, B) }; .broadcast(achieve, visit).
