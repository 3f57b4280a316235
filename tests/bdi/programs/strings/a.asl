!go.
+!go <- .concat("ab","cd",S); .print(S); .length(S,N); .print(N); .substring("bc",S); .print("say \"hi\""); .print("a\tb");
   .term2string(T,"f(1,x)"); .print(T); .print(f("q")); .upper_case(S,U); .print(U); .print.
