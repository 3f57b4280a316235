!go.
+!go <- !t1; !t2; !t3; !t4; !t5; .print(end).
+!t1 <- !!x; .print(1); .drop_desire(x); .print(2).
+!x <- .print(x1); .print(x2); .print(x3).
+!t2 <- !!y; .wait(2); .drop_intention(y); .print(3).
+!y <- .print(y1); .wait(50); .print(y2).
+!t3 <- !!z; .wait(2); .succeed_goal(zz); .wait(5); .print(4).
+!z <- .print(z1); !zz; .print(z2).
+!zz <- .wait(100); .print(no).
+!t4 <- !!u; .wait(2); .fail_goal(uu); .wait(5); .print(5).
+!u <- .print(u1); !uu; .print(no).
-!u <- .print("u failed").
+!uu <- .wait(100); .print(no).
+!t5 <- !!v1; !!v2; .wait(2); .drop_all_desires; .print(6); .wait(300); .print(7).
+!v1 <- .wait(10); .print(v1).
+!v2 <- .wait(20); .print(v2).
