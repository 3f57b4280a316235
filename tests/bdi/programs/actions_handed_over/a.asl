// An internal action in the place of a term is handed over, and asked where its variable is a condition.
q(1). q(2).
!go.
+!go <- !check(.atom(b)); !check(.member(3,[1,2])); !check(.length([a],1)); !holds(.findall(X, q(X) & X > 1, [2]));
   N = .length([a,b]) + 1; .print(N); +rule(.member(Y,[5,6])); ?rule(C); ?C; .print(C); for (C) { .print(C) }.
+!check(C) : C <- .print("yes ", C).
+!check(C) <- .print("no ", C).
+!holds(C) : C <- .print(holds).
