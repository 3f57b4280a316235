// !! starts an intention of its own, ! waits.
!go.
+!go <- !!side(1); .print("go on"); !inside; .print("end").
+!inside <- .print("inside").
+!side(N) <- .print("side ",N).
