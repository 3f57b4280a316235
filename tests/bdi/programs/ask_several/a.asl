// Several agents asked at once: the answers are a list, in the order in which they came.
!go.
+!go <- .send([b,c],askOne,price(apple,_),L); .length(L,N); .print(N); .sort(L,S); .print(S);
   .send([b],askOne,price(fig,_),M); .print(M); .send([b,c],askAll,price(_,_),K); .print(K); .print("end").
