// What plans for failures are told.
!go.
+!go <- !t(1); !t(2); !t(3); !t(4); !t(5).
+!t(1) <- .member(5,[1,2]).
+!t(2) <- !undefined(4).
+!t(3) : nothing.
+!t(4) <- ?known(4); .print("never").
+!t(5) <- .fail(error(mine),error_msg("my own words"),other(7)).
-!t(5)[error(E),error_msg(M),other(O)] <- .print(E," ",M," ",O).
-!t(N)[error(E),error_msg(M)] <- .print(N," ",E," <",M,">").
