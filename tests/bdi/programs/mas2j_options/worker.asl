+!start : size(N) & colour(C) & .my_name(Me) <- .print(Me," ",N," ",C).
