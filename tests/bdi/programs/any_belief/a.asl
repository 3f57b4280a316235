// A variable without a value asks for every belief, `_` stands for all that `.abolish` can remove.
b(1). c(2)[k]. r(X) :- b(X).
!go.
+!go <- if (B[k]) { .print(B) }; .findall(X, X, L); .print(L); if (not Q[nothing]) { .print(none) };
   .count(M[source(self)], N); .print(N); .abolish(_[k]); .findall(X, X, L2); .print(L2); .abolish(_); .findall(X, X, L3); .print(L3).
-b(X) <- .print("minus ", X).
-c(X) <- .print("minus ", X).
