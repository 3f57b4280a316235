// What public models rely on in built-ins.
!go.
+!go <- for (.member(T, [a, f(1), ~a, a[x], [1], [], "s", 1])) { if (.structure(T)) { .print(T) } };
   .findall(S, .sublist(S,[a,b,c]), L); .print(L); .delete(f(_),[f(1),g(1),f(2),f(1)],D); .print(D); .delete(X,[1,2],E); .print(E, X);
   .delete(a,[a,b,a],F); .print(F); .add_annot([a,b(1),[c],2], k, G); .print(G); !e(1); !e(2); !e(3); !e(4); !e(5); !e(6); !e(7); !!w; .wait(0); .print(w2).
+!w <- .print(w1).
+!e(1) <- .nth(9,[a],X).
+!e(2) <- .length(5,X).
+!e(3) <- .fail(my(1)).
+!e(4) <- .fail(error(mine)).
+!e(5) <- .fail.
+!e(6) <- .send(ghost, tell, hi).
+!e(7) <- .send(To, tell, hi).
-!e(4)[error(mine)] <- .print("4 mine").
-!e(N)[error(E)] <- .print(N, " ", E).
