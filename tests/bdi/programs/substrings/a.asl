!go.
+!go <- .findall(X,.substring("a","abbacca",X),L); .print(L); .substring(a(10),b(t1,a(10)),P); .print(P);
   .substring(a(10,20),R,5); .print(R); .substring(a(10,20),R2,5,7); .print(R2); .substring("hello world",W,6); .print(W);
   if (not .substring("b","aaa")) { .print(no) }; if (not .substring("a","bbacc",0)) { .print("not at 0") };
   .substring("short",Z,3,9); .print("never").
-!go[error(E)] <- .print(E).
