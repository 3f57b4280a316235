!x. !y.
@l1[atomic] +!x <- .print("x1"); .print("x2"); !sub; .print("x3").
+!sub <- .print("sub").
+!y <- .print("y1"); .print("y2").
