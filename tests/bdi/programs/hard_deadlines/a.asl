// A goal that is not achieved in time fails, and all that was done for it; others go on.
!go.
+!go <- !slow(1)[hard_deadline(40)]; !fast[hard_deadline(40)]; !outer[hard_deadline(50)]; !alone[hard_deadline(20)];
   !!later[hard_deadline(30)]; .wait(100); !count(3)[hard_deadline(50)]; !never[hard_deadline(10)]; .print(end).
+!slow(X) <- .wait(200); .print(never).
-!slow(X)[error(E)] <- .print("slow ", E).
+!fast <- .wait(2); .print(fast).
+!outer <- !inner[hard_deadline(10)]; .print(never).
-!outer[error(E)] <- .print("outer ", E).
+!inner <- .wait(30); .print(never).
-!inner[error(E)] <- .print("inner ", E); .wait(100); .print(never).
@alone[atomic] +!alone <- .wait(300); .print(never).
-!alone[error(E)] <- .print("alone ", E).
+!later <- !sub. +!sub <- .wait(2000); .print(never).
-!later[error(E)] <- .print("later ", E).
+!count(N) : N > 0 <- .wait(20); .print(N); !count(N - 1).
+!count(0) <- .print(never).
-!count(N)[error(E)] <- .print("count ", N, " ", E).
+!never <- .suspend; .print(never).
-!never[error(E)] <- .print("never ", E).
