p(1). p(2).
!g.
+!g <- X = .count(p(_))+1; .print(X); Y = .length([a,b])*2; .print(Y); if (.count(p(_)) > 1) { .print("many") }.
