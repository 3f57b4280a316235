a.
!g.
+!g : (b | a) & not (c & d) <- X = 5 - -3; .print(X); Y = -(2+3); .print(Y); .print(7-2-1," ",2+3*4," ",2**3," ",-2**2);
   if (not a & b | a) { .print("or binds last") }.
