// Plans that take lists apart, and a result handed back through a goal's variable.
!go.
+!go <- !sum([3,4,5],S); .print("sum ",S); !reverse([1,2,3],[],R); .print(R); !last([a,b,c],L); .print("last ",L).
+!sum([],0).
+!sum([H|T],S) <- !sum(T,R); S = R+H.
+!reverse([],A,A).
+!reverse([H|T],A,R) <- !reverse(T,[H|A],R).
+!last([X],X).
+!last([_|T],X) <- !last(T,X).
