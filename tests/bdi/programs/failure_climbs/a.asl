// The nearest failure plan in the stack takes over; what its goal was called from goes on.
!go.
+!go <- !a; .print("after a").
-!go <- .print("not here").
+!a <- !b; .print("not reached").
-!a[error(E)] <- .print("a failed: ",E).
+!b <- !c; .print("not reached").
+!c <- .print("in c"); ?missing(X); .print("not reached").
