// A failure in the body of a failure plan, or of a plan for a belief, is not handled: the intention is dropped.
!g. !h. !last.
+!g <- !a; .print("not reached").
-!g <- .print("not reached").
+!a <- .fail.
-!a <- .print("a handler"); .fail.
+!h <- +p; .print("not reached").
-!h <- .print("not reached").
+p <- .print("p"); .fail.
+!last <- .wait(10); .print("lives on").
