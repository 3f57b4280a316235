!go.
+!go <- .delete(a,[a,b,c,a],L); .print(L); if (not .delete(a,[a,b,c,a],[c])) { .print(no) }; .delete(0,[a,b,c,a],M); .print(M);
   .delete(1,3,[a,b,c,a],N); .print(N); .delete("a","banana",S); .print(S); .delete(0,"banana",T); .print(T);
   .delete(1,4,"banana",U); .print(U).
