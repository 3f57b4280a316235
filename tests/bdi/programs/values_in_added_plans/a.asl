!go.
+!go <- X = 5; .add_plan({ +!show : true <- .print(X) }); !show; .add_plan({ @l[atomic] +!sum(Q) : Q < X <- .print(X+Q) });
   !sum(1); .print({ +!h(Q) : X > 3 <- .print(X) }); !!later; .wait({ +b(X) }); .print("got it"); .wait({ +c(Y) }); .print(Y);
   D = f(C); if (not C = g(D) & not A = { x(A); y }) { .print("no endless term") }.
+!later <- .wait(5); +b(1); .wait(5); +b(5); .wait(5); +c(9).
