seen(cat)[at(1),by(ann)]. seen(cat)[by(bob)]. seen(dog)[at(2)].
!go.
+!go <- .findall(W,seen(cat)[by(W)],L); .print(L); .findall(X,seen(X)[at(_)],M); .print(M);
   if (seen(dog)[by(_)]) { .print("yes") } else { .print("no") }; ?seen(dog)[at(T)]; .print(T+1);
   +seen(cow)[at(5)]; ?seen(cow)[source(S),at(A)]; .print(S," ",A).
