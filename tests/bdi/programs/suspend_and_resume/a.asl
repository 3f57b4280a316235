// What is suspended while it waits does not go on when its wait is over.
!g.
+!g <- !!h; .wait(5); .suspend(h); .wait(20); .print("resuming"); .resume(h).
+!h <- .wait(10); .print("h1"); .wait(10); .print("h2").
