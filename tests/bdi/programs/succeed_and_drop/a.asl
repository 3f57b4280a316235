!go.
+!go <- !!long; !!other; .wait(10); .succeed_goal(long); .drop_intention(other); .wait(10); .print("go end").
+!long <- !deep; .print("long not reached").
+!deep <- .wait("+never").
+!other <- .wait("+never"); .print("other not reached").
