area(2).
!go.
+!go <- ?area(X); .print(X); ?double(area,Y); .print(Y); ?(area(Z) & Z < 3); .print("small ",Z).
+?double(area,Y) : area(X) <- Y = X*2.
