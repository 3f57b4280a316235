!g. !h. !i(1,X).
+!g : true <- true.
+!h <- .print("h"); true; .print("again").
+!i(Y,X) <- .print("i ",Y);
   .print(+3 + +(4));
   .
