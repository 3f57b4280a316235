!go.
+!go <- .print(10/4," ",10/5," ",7 div 2," ",-7 mod 3," ",2**10," ",1/3); .print(0.1+0.2); X = 3; Y = X*2-1; .print(Y);
   if (1 == 1.0) { .print("same") }; .print(math.abs(-3)," ",math.max(2,7)," ",math.sqrt(16)," ",math.round(2.5));
   if (a < b & "a" < "b" & 3 < a) { .print("ordered") }; .print(1000000*1000000); .print(1/1000000).
