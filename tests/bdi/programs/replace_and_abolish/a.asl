p(1). p(2). p(3).
!go.
+!go <- -+p(9); .findall(X,p(X),L); .print(L); .abolish(p(_)); .count(p(_),N); .print(N); -p(7); +p(5); +p(5); .count(p(_),M); .print(M).
-p(X) <- .print("gone ",X).
