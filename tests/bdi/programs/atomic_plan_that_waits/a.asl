!x. !y.
@l[atomic] +!x <- .print("x1"); .wait(10); .print("x2").
+!y <- .print("y1").
