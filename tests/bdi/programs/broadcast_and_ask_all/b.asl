item(1). item(2).
+hello[source(S)] <- .print("hello ",S).
+!say(X) <- .print(X).
