!start.
+!start <- .send(b,achieve,ping(3)).
+!pong(N)[source(S)] : N > 0 <- .print("pong ",N); .send(S,achieve,ping(N-1)).
+!pong(0) <- .print("over").
