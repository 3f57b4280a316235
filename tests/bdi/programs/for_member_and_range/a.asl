!go.
+!go <- for (.member(X,[a,b])) { .print(X) }; for (.range(I,1,3)) { .print(I*I) };
   for (.member(X,[1,2]) & .member(Y,[u,v])) { .print(X,Y) }; .print("done").
