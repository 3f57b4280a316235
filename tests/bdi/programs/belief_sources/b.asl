hot.
+hot[source(S)] <- .print("hot from ",S).
-hot[source(S)] <- .print("not hot from ",S).
+cold(X)[source(a)] <- .print("cold ",X).
+!report(W)[source(S)] : hot[source(self)] <- .print("report ",W," to ",S); .findall(X,hot[source(X)],L); .print(L).
