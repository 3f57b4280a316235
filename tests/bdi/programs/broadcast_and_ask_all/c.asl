+hello[source(S)] <- .wait(10); .print("hi ",S).
+!say(X) <- .wait(20); .print(X).
