!go.
+!go <- .send(b,tellRule,"old(X) says hello"); .send(b,count,[p(1),p(2)]); .send(b,nobody_knows,x); .send(b,tell,p(3)); .print(sent).
