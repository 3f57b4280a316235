+!kqml_received(A,tellRule,Rule,_) <- .print(A," tells the rule ",Rule).
+!kqml_received(A,count,L,_) <- .length(L,N); .print("counted ",N).
+p(X)[source(S)] <- .print("p ",X," ",S).
