todo([wash(cup),dry(cup)]).
!go.
+!go : todo(L) <- for (.member(G,L)) { !G }; B = done(all); +B; if (done(X)) { .print("done ",X) }.
+!wash(X) <- .print("wash ",X).
+!dry(X) <- .print("dry ",X).
