!bad. !good.
+!bad <- .print("bad 1"); .fail; .print("bad 2").
+!good <- .print("good 1"); .print("good 2"); .print("good 3").
