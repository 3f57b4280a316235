// The steering agent: hands the chosen beliefs to the person.
// lint: percepts chosen
!steer.
+!steer <- for (chosen(B)) { .send(my_person, tell, B) }; .send(my_person, achieve, visit).
