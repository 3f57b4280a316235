!go.
+!go <- f(X,[H|T]) = f(1,[a,b,c]); .print(X," ",H," ",T); if (f(X) == f(1)) { .print("equal") }; if (a \== b) { .print("different") };
   p(1,b)[z] =.. L; .print(L); Q =.. [r,[1,2],[]]; .print(Q); .print([1,[2,x],"s",f(Y2)[q]]); if (not (a = b)) { .print("not unifiable") }.
