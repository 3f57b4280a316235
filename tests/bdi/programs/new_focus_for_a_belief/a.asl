!g.
+!g <- ++p(1); .print("go on"); +p(2); .print("after two").
+p(X) <- .print("p ",X); .print("end of ",X).
