!go.
+!go <- !!task(1); if (.desire(task(_))) { .print("desired") }; .wait(10);
   if (.intend(task(X))) { .print("intended ",X) }; .drop_desire(task(_)); .wait(5);
   if (not .intend(task(_))) { .print("dropped") }.
+!task(N) <- .wait("+go(N)"); .print("not reached").
