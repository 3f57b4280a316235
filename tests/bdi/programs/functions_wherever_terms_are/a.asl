d(X,Y,D) :- D = math.sqrt(X*X+Y*Y).
!go.
+!go <- .wait(math.random(50)); .wait(math.round(2.4)+math.abs(-3)); !g(math.abs(-3)); +p(math.floor(2.5)); ?p(X); .print(X);
   if (math.abs(-2) > 1 & .length([1,2]) == 2) { .print(yes) }; ?d(3,4,D); .print(D); .print([math.abs(-1),f(math.sqrt(9))]);
   -+cnt(math.min(3,2)); ?cnt(C); .print(C); .print(.count(cnt(_))," ",.length("abc")*2," ",math.ceil(-0.5));
   ~q(1)[a] =.. L; .print(L); Q =.. [~q,[2],[]]; .print(Q).
+!g(N) <- .print("g",N).
