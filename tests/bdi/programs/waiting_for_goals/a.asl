// A goal for a new intention, or asked for by another agent, is waited for as one in the same is.
!go. !later.
+!go <- .wait({+!ping(X)}); .print("ping ",X); .wait("+done(Y)",1000); .print(Y); .wait({-done(_)}); .print("not done");
   .wait({+!pong(Z)}); .print("pong ",Z).
+!later <- .wait(5); !!ping(3); .wait(5); +done(4); .wait(5); -done(4); .wait(5); .send(self,achieve,pong(7)).
+!ping(X) <- .print("handling ",X).
+!pong(_).
