!go.
+!go <- .random(X); .random(Y,3); if (X >= 0 & X < 1 & Y < 1) { .print("from 0 to 1") }; .findall(R,.random(R,4),L);
   .length(L,N); .print(N); ?.random(Z,0) & Z > 0.9; .print("one of many").
