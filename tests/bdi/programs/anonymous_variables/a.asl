// `_` and `_name` are other variables at each place, `_1` is the same one in its plan.
p(1,2). q(3,3).
!go.
+!go <- f(_,_) = f(1,2); f(_q,_q) = f(1,2); .print(yes); f(_1,_1) = f(3,3); .print(_1); g(_,_1,_) = g(7,3,8); .print(same);
   if (p(_x,_x)) { .print(anonymous) }; if (p(_2,_2)) { .print(no) } else { .print("not both") }; ?q(_2,_2); .print(_2);
   !own(_,_2).
+!own(_1,_2) <- .print(_2); _1 = 9; .print(_1); !other(_2).
+!other(_1) <- .print(_1).
