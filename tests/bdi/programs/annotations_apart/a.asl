p[a(1),b].
!g.
+!g <- ?p[a(X)|R]; .print(X," ",R); Q = foo(1); +Q[src(z)]; ?foo(Y)[src(W)]; .print(Y," ",W); .add_annot(bar,k(3),B); .print(B).
