!go.
@g +!go <- X = 1; .at("now +20 ms",{+!later(X)}); .at("now +1 s",{+b(2)}); .at("now +2 minutes","+!later(3)"); .print(set);
   .wait(1500); .print(waited); .date(Y,M,D); .wait(86400000); .date(Y,M,E); .print(E-D); F = E-D; .puts("#{F} day, ","[#{X}] #{F+1}");
   !about; .at("in a while",{+b(3)}).
-!go[error(E)] <- .print(E).
@s +!about <- .current_intention(intention(_,[im(L,_,_,_),im(M,_,B,_)])); .print(L," ",M).
+!later(X) <- .print("later ",X).
+b(X) : not b(X) <- .print("only the event of b",X).
