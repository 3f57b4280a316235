!go.
+!go <- !t(1); !t(2); !t(3); !t(4); !t(5); .print("end").
+!t(1) <- ?unknown.
+!t(2) <- .fail.
+!t(3) <- X = 1; X > 2; .print("no").
+!t(4) <- !nowhere.
+!t(5) : nothing.
-!t(N)[error(E)] <- .print(N," ",E).
