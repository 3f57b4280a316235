count(3).
!go.
+!go <- while (count(N) & N > 0) { .print("n ",N); -+count(N-1) }; ?count(M); .print("end ",M).
