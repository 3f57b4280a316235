!go.
+!go <- .print(1/0," ",-1/0," ",0/0," ",5 mod 0," ",math.sqrt(-1)," ",math.log(0)," ",math.asin(2)," ",(-8)**(1/3)," ",0**(-1));
   .print(10**400," ",(-10)**401," ",2**63," ",-(2**63)," ",2**64); .print(math.log(-1)," ",7.5 mod 2," ",-7 mod 3," ",1/0-1/0);
   X = 1/0; Y = 3; if (X > Y & not X < Y & -X < Y) { .print("above all") }; Z = 5 div 0; .print(never).
-!go[error(E)] <- .print(E).
