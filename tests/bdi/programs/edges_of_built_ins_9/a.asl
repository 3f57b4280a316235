p(1). p(2). cnt(0).
!run.
+!run <- .print("#0"); !t0; .print("#1"); !t1; .print("#2"); !t2; .print("#3"); !t3; .print("#4"); !t4; .print("#5"); !t5; .print("#6"); !t6; .print("#7"); !t7; .print("#8"); !t8; .print("#9"); !t9; .print("#10"); !t10; .print("#11"); !t11; .print("#12"); !t12; .print("#13"); !t13; .print("#14"); !t14; .print("#15"); !t15; .print("#16"); !t16; .print("#17"); !t17; .print("#18"); !t18; .print("#19"); !t19; .print("#20"); !t20; .print("#21"); !t21; .print("#22"); !t22; .print("#23"); !t23; .print("#24"); !t24; .print("#25"); !t25; .print("#26"); !t26; .print("#27"); !t27; .print("#28"); !t28; .print("#29"); !t29; .print("#30"); !t30; .print("#31"); !t31; .print("#32"); !t32; .print("#end").
+!t0 <- !atomic1; .print(after).
-!t0[error(E)] <- .print("failed ",E).
+!t1 <- !!aa; !!bb; .wait(60); .print(done).
-!t1[error(E)] <- .print("failed ",E).
+!t2 <- !rec(3).
-!t2[error(E)] <- .print("failed ",E).
+!t3 <- !ctx(5).
-!t3[error(E)] <- .print("failed ",E).
+!t4 <- !ctx(15).
-!t4[error(E)] <- .print("failed ",E).
+!t5 <- !ctx(a).
-!t5[error(E)] <- .print("failed ",E).
+!t6 <- !argl([1,2,3]).
-!t6[error(E)] <- .print("failed ",E).
+!t7 <- !str("hi").
-!t7[error(E)] <- .print("failed ",E).
+!t8 <- !opt(X); .print(X).
-!t8[error(E)] <- .print("failed ",E).
+!t9 <- !two(A,B); .print(A,B).
-!t9[error(E)] <- .print("failed ",E).
+!t10 <- ?rule(X); .print(X).
-!t10[error(E)] <- .print("failed ",E).
+!t11 <- +z(1); +z(2); -z(1); .findall(X,z(X),L); .print(L).
-!t11[error(E)] <- .print("failed ",E).
+!t12 <- +z(3)[why(me)]; ?z(3)[why(W)]; .print(W).
-!t12[error(E)] <- .print("failed ",E).
+!t13 <- -z(3)[why(me)]; .count(z(3),N); .print(N).
-!t13[error(E)] <- .print("failed ",E).
+!t14 <- +z(4); +z(4)[w(1)]; ?z(4)[w(V)]; .print(V); .count(z(4),N); .print(N).
-!t14[error(E)] <- .print("failed ",E).
+!t15 <- -+z(9); .findall(X,z(X),L); .print(L).
-!t15[error(E)] <- .print("failed ",E).
+!t16 <- +ev(1); .wait(30); -ev(1); .wait(30).
-!t16[error(E)] <- .print("failed ",E).
+!t17 <- !gf; .print(ok).
-!t17[error(E)] <- .print("failed ",E).
+!t18 <- !gf2; .print(no).
-!t18[error(E)] <- .print("failed ",E).
+!t19 <- !gf3(7).
-!t19[error(E)] <- .print("failed ",E).
+!t20 <- !dd; .print(ok).
-!t20[error(E)] <- .print("failed ",E).
+!t21 <- !!lp(3); .wait(60); .print(ok).
-!t21[error(E)] <- .print("failed ",E).
+!t22 <- ?tst(X); .print(X).
-!t22[error(E)] <- .print("failed ",E).
+!t23 <- !if1(3).
-!t23[error(E)] <- .print("failed ",E).
+!t24 <- !if1(-3).
-!t24[error(E)] <- .print("failed ",E).
+!t25 <- !wh.
-!t25[error(E)] <- .print("failed ",E).
+!t26 <- !fr.
-!t26[error(E)] <- .print("failed ",E).
+!t27 <- !nest.
-!t27[error(E)] <- .print("failed ",E).
+!t28 <- !ann[k(v)].
-!t28[error(E)] <- .print("failed ",E).
+!t29 <- !ann2(1)[k(v),w].
-!t29[error(E)] <- .print("failed ",E).
+!t30 <- !strneg.
-!t30[error(E)] <- .print("failed ",E).
+!t31 <- !cb.
-!t31[error(E)] <- .print("failed ",E).
+!t32 <- !big(1000).
-!t32[error(E)] <- .print("failed ",E).
@at [atomic] +!atomic1 <- !in1; .print(a1); !in2; .print(a2).
+!in1 <- .print(i1). +!in2 <- .print(i2).
+!aa <- .print(a1); .print(a2); .print(a3). +!bb <- .print(b1); .print(b2); .print(b3).
+!rec(0) <- .print(zero). +!rec(N) : N > 0 <- .print(N); !rec(N-1).
+!ctx(X) : X < 10 <- .print(small). +!ctx(X) : X >= 10 & .number(X) <- .print(large). +!ctx(X) <- .print(other).
+!argl([]) <- .print(end). +!argl([H|T]) <- .print(H,T); !argl(T).
+!str(S) : .string(S) <- .print(S).
+!opt(X) : p(X) & X > 1. +!two(1,B) <- B = f(C); C = 2.
+?rule(X) : p(Y) <- X = Y + 10.
+ev(X)[source(S)] <- .print(added,X,S). -ev(X)[source(S)] <- .print(removed,X,S).
+!gf <- .fail. -!gf <- .print(h).
+!gf2 <- !gf2b. +!gf2b <- ?nonex. -!gf2[error(E),error_msg(M),code(C),code_line(L)] <- .print(E,"/",M,"/",C).
+!gf3(X) <- +bel(X); ?bel(8). -!gf3(X)[error(E)] : X > 5 <- .print(big,E). -!gf3(X) <- .print(small).
+!dd <- !!dd2; .drop_desire(dd2). +!dd2 <- .print(no).
+!lp(0). +!lp(N) <- .print(N); !!lp(N-1).
+?tst(3) <- .print(asked).
+!if1(X) <- if (X > 0) { .print(pos); Y = 1 } else { .print(neg); Y = 2 }; .print(Y).
+!wh <- -+cnt(0); while (cnt(N) & N < 2) { -+cnt(N+1); .print(N) }; ?cnt(M); .print(M).
+!fr <- for (.member(X,[1,2]) & p(X)) { .print(X); Y = X }; .print(Y).
+!nest <- for (p(X)) { if (X == 1) { .print(one) } else { for (.range(I,1,2)) { .print(X,I) } } }.
+!ann[k(X)] <- .print(X). +!ann2(A)[k(X)|T] <- .print(A,X).
+!strneg <- +~p(1); if (~p(1)) { .print(neg) }; if (not ~p(2)) { .print(none) }; -~p(1); .count(~p(_),N); .print(N).
+!cb <- .findall(X, p(X) & not (X == 1), L); .print(L); .count((p(X) & X < 5), N); .print(N).
+!big(N) <- .findall(I,.range(I,1,N),L); .length(L,K); .print(K); .nth(999,L,V); .print(V); S = math.sum(L); .print(S).
