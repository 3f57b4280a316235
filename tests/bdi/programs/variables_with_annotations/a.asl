// A variable that is written with annotations stands for the literal without any; alone, it keeps all.
!go.
+!go <- !move(kitchen); !keep(1); !take(b(1)[k,m]); X[k] = b(1)[k,m]; .print(X);
   if (Y[z] = b(1)) { .print(no) } else { .print("not annotated") };
   c(1)[k,m] = U[k]; .print(U); V[k|R] = c(2)[k,m]; .print(V, " ", R); d(3)[k] = W; .print(W);
   [H[k]|T] = [e[k,l],f]; .print(H, " ", T); +g(1)[k]; -g(1)[k]; !signs.
+!move(R) <- .fail.
-!G[error(E)] : G == move(kitchen) <- .print("the same ", G).
-!G[error(E)] <- .print("another ", G).
+!keep(N) <- !none(N).
+!take(P[k]) <- .print(P).
+B[source(self)] <- .print("new ", B).
-B[source(self)] <- .print("gone ", B).
-B[k] <- .print("less ", B).
+!signs <- ~N = ~h(1); .print(N); M = h(2); +~M; ?~M; .print("believed ~", M); ~O[k] = ~h(3)[k,m]; .print(O);
   if (~P = h(4)) { .print(no) } else { .print("not negated") }; Q = ~h(5); ~R = Q; .print(R, " ", Q).
+~C[source(self)] <- .print("new negated ", C).
