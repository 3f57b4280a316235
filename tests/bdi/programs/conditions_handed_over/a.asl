// A goal may hand over a condition, with the values that its variables have; it binds those of the goal's own plan.
b(1). b(5).
!go.
+!go <- X = 3; !check(X > 2 & b(X+2)); !check(not b(9) | X < 0); !check(X > 5); !check(b(Z) & Z > 2); .print(Z);
   !ask(.member(Q,[1,2])); .print(Q); B = { !show(2 > 3) }; !run(B); .add_plan({+!added <- !show(X > 4)}); !added.
+!check(C) : C <- X = 77; .print("yes ", C); if (C) { .print(again) }.
+!check(C) <- .print("no ", C).
+!ask(C) <- X = 5; ?C; .print(C, X).
+!show(C) <- .print(C).
+!run(B) <- B.
