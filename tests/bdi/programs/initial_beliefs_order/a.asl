p(1). p(2). p(3).
!go.
+!go <- .findall(X,p(X),L); .print(L); +p(4); .findall(X,p(X),M); .print(M); ?p(Y); .print(Y).
