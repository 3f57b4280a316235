!go.
+!go <- for (.member(X,[1,5,9])) { if (X < 3) { .print(X," low") } elif (X < 7) { .print(X," middle") } else { .print(X," high") } };
   if (true) { Y = 2 }; .print(Y).
