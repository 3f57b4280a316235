!go.
+!go <- +x[source(bob)]; +x; ?x[source(S)]; .print(S); .findall(Q,x[source(Q)],L); .print(L); -x; .findall(Q2,x[source(Q2)],L2); .print(L2);
  +y(1)[source(bob),w(1)]; -y(1)[source(bob)]; if (y(1)) {.print(yes)} else {.print(no)};
  +v(1); +v(2); +v(3); -v(2); .findall(X,v(X),L3); .print(L3); -v(_); .findall(X3,v(X3),L4); .print(L4);
  +p(a)[w(1)]; +p(a)[w(2)]; ?p(a)[w(A)|R]; .print(A," ",R); p(a)[x] = p(a)[x,y]; .print(sub); if (not (p(a)[x,y] = p(a)[x])) {.print(notsub)};
  C = p(b)[q]; .print(C); +C; ?p(b)[q,source(SS)]; .print(SS); .add_annot(foo(1),bar,D); .print(D); .add_nested_source(a,bob,E); .print(E).
