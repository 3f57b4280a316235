q(7).
+x(N)[source(S)] <- .print("x",N," ",S).
-x(N)[source(S)] <- .print("-x",N," ",S).
+!g1[source(S)] <- .print("g1 ",S).
+!g2 <- .print("g2").
+!long <- .print("long"); .wait(1000); .print("not").
+?val(X,Y) <- Y = X*2.
+!bye <- .print("bye").
