sum([],0).
sum([H|T],S) :- sum(T,R) & S = R+H.
!g.
+!g <- .findall(X,.range(X,1,300),L); ?sum(L,S); .print(S); !add(L,0,A); .print(A); !down(300); .print("up again").
+!add([],A,A).
+!add([H|T],A,S) <- !add(T,A+H,S).
+!down(0) <- .print("bottom").
+!down(N) <- !deeper(N-1).
+!deeper(N) <- !down(N); -+seen(N).
