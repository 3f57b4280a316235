!s.
+!s <- +obs(1); .print(1); .wait({+obs(2)},100); .print("no").
-!s[error(E),error_msg(M)] <- .print(E,":",M); .wait({+obs(3)},50,T); .print("waited"); !t.
+!t <- !!sig; .wait("+obs(4)"); .print("obs4"); .wait({+!h(X)}); .print("h",X).
+!sig <- .wait(5); +obs(4); .wait(5); !h(7).
+!h(X) <- .print("in h").
