!go.
+!go <- L = [3,1,2]; .length(L,N); .print(N); .sort(L,S); .print(S); .max(L,A); .min(L,B); .print(A," ",B);
   .concat(L,[x],C); .print(C); .concat("a",1,b,T); .print(T); .nth(0,L,F); .print(F); .reverse(L,R); .print(R);
   .member(2,L); .delete(1,L,D); .print(D); .union([a,b],[b,c],U); .print(U);
   .difference([a,b,c],[b],E); .print(E); .intersection([a,b],[b,c],I); .print(I); .print("text ",["a",b,"c d"]);
   .sort([c,"x",2,f(1),[1],B2,~a,a],O); .length(O,ON); .print(ON).
