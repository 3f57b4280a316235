!go.
+!go <- !sorted([3,1,2]); !try(0); .print(end).
+!sorted(L) <- .length(L,N); for (.range(I,0,N-1)) { .nth(I,L,V); +arr(I,V) }; !bubble; .findall(v(I2,V2),arr(I2,V2),R); .sort(R,S); .print(S).
+!bubble : arr(I,A) & arr(J,B) & J = I+1 & A > B <- -arr(I,A); -arr(J,B); +arr(I,B); +arr(J,A); !bubble.
+!bubble.
+!try(N) : N < 3 <- .print("try ",N); !risky(N); .print("succeeded ",N).
+!risky(N) : N == 2.
-!try(N) <- .print("retry after ",N); !try(N+1).
