edge(a,b,2). edge(b,c,3). edge(a,c,9). edge(c,d,1).
path(X,Y,D) :- edge(X,Y,D).
path(X,Y,D) :- edge(X,Z,A) & path(Z,Y,B) & D = A+B.
shortest(X,Y,D) :- .findall(E,path(X,Y,E),L) & .min(L,D).
isolated(X) :- node(X) & not edge(X,_,_) & not edge(_,X,_).
node(e). node(a).
fact(0,1).
fact(N,F) :- N > 0 & fact(N-1,G) & F = N*G.
!go.
+!go : path(a,d,First) <- .print(First); ?shortest(a,d,D); .print(D); .findall(X,isolated(X),L); .print(L); ?fact(10,F); .print(F);
   .findall(E,path(a,c,E),Es); .print(Es).
