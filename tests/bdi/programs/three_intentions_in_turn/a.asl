// Each statement is a cycle of its own; an event for a belief is waited for, at the end of the row.
!a. !b. !c.
+!a <- .print(a1); !a2; .print(a3).
+!a2 <- .print(a2).
+!b <- +bel; .print(b2); +bel2; .print(b3).
+bel <- .print(bel).
+!c <- for (.range(I,1,3)) { .print(c,I) }; if (bel) { .print(cb) }.
