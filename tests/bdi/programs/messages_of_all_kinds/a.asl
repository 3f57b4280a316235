item(1). item(2).
!go.
+!go <- .send(b,tell,[x(1),x(2)]); .wait(20); .send(b,achieve,[g1,g2]); .wait(20); .send(b,untell,x(1)); .wait(20);
  .send(b,achieve,long); .wait(30); .send(b,unachieve,long); .wait(30);
  .send(b,askOne,x(_),A); .print(A); .send(b,askAll,x(_),L); .print(L); .send(b,askOne,q(_)); .wait(20);
  .send(b,askOne,val(3,Y),V); .print(V); val(_,W)[source(_)] = V; .print(W);
  .send(b,tellHow,"+!new(X) <- .print(\"new \",X)."); .send(b,achieve,new(5)); .wait(20);
  .send(b,askHow,{+!g1},P); .print(P);
  .send(a,tell,me); .wait(10); ?me[source(S)]; .print(S);
  .broadcast(achieve,bye); .print(end).
+q(X)[source(S)] <- .print("got q ",X," ",S).
