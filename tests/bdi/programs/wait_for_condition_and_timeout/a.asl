!go.
+!go <- !!feed; .wait(level(X) & X >= 2); .print("level reached"); !short; .print("end").
+!feed <- .wait(5); +level(1); .wait(5); -+level(2).
+!short <- .wait("+never",30); .print("not reached").
-!short[error(E)] <- .print("timeout: ",E).
