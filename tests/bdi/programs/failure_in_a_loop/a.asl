!g.
+!g <- for (.member(X,[1,2,3])) { !t(X) }; .print("end").
+!t(2) <- .fail.
+!t(X) <- .print(X).
-!t(X) <- .print("bad ",X).
