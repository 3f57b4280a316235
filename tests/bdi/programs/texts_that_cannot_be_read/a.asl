!go.
+!go <- for (.range(N,1,6)) { !t(N) }; .send(self,tellHow,"+!x <- "); .wait(5); .print(end).
+!t(1) <- .wait("+done(",10).
+!t(2) <- .add_plan("garbage").
+!t(3) <- .term2string(X,"p("); .print(X).
+!t(4) <- .relevant_plans("x",L).
+!t(5) <- .puts("#{X+}").
+!t(6) <- .at("now +1 s","garbage(").
-!t(N)[error(E)] <- .print(N," ",E).
