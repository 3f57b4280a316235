p(4).
!go.
+!go <- !do({ .print(1); .print(2) }); .print(3); X = 7; B = { .print(X); Y = X+1; .print(Y) }; B; .print(Y);
   !twice({ .print(hi) }); !do({ ?p(Z); .print(Z); !sub(Z) });
   for (.member(M,[{ .print(a) },{ .print(b); .print(c) }])) { M };
   !make({ .print(in); .print(side) }); !made; !fails({ .print(before); .fail }).
+!do(B) <- Z = 99; B.
+!twice(B) <- B; B.
+!sub(Z) <- .print("sub ",Z).
+!make(Action) <- .add_plan({ +!made <- .print(start); Action; .print(stop) }).
+!fails(B) <- B; .print(never).
-!fails(_)[error(E)] <- .print(E).
