// A test may be of any condition, with or without brackets around it.
p(1). p(5).
!go.
+!go <- ?p(X) & X > 2; .print(X); ?(p(Y) & Y < 2); .print(Y); ?not q(1); ?q(Z) | p(Z); .print(Z); !fails.
+!fails <- ?p(X) & X > 5; .print(X).
-!fails[error(E)] <- .print(E).
