p(1)[k(1)]. p(2)[source(bob),k(2)]. w(move(kitchen)[fast]).
!run.
+!run <- .print("#0"); !t0; .print("#1"); !t1; .print("#2"); !t2; .print("#3"); !t3; .print("#4"); !t4; .print("#5"); !t5; .print("#6"); !t6; .print("#7"); !t7; .print("#8"); !t8; .print("#9"); !t9; .print("#10"); !t10; .print("#11"); !t11; .print("#12"); !t12; .print("#13"); !t13; .print("#14"); !t14; .print("#15"); !t15; .print("#16"); !t16; .print("#17"); !t17; .print("#18"); !t18; .print("#19"); !t19; .print("#20"); !t20; .print("#21"); !t21; .print("#22"); !t22; .print("#23"); !t23; .print("#24"); !t24; .print("#25"); !t25; .print("#26"); !t26; .print("#27"); !t27; .print("#28"); !t28; .print("#29"); !t29; .print("#30"); !t30; .print("#31"); !t31; .print("#32"); !t32; .print("#33"); !t33; .print("#34"); !t34; .print("#35"); !t35; .print("#36"); !t36; .print("#37"); !t37; .print("#38"); !t38; .print("#39"); !t39; .print("#40"); !t40; .print("#41"); !t41; .print("#42"); !t42; .print("#43"); !t43; .print("#44"); !t44; .print("#45"); !t45; .print("#end").
+!t0 <- X = foo(1)[a,b]; X[a] = Y; .print(Y).
-!t0[error(E)] <- .print("failed ",E).
+!t1 <- X = foo(1)[a,b]; X[c] = Y; .print(no).
-!t1[error(E)] <- .print("failed ",E).
+!t2 <- X[k] = t; .print(X).
-!t2[error(E)] <- .print("failed ",E).
+!t3 <- ?p(X)[source(bob)]; .print(X).
-!t3[error(E)] <- .print("failed ",E).
+!t4 <- .findall(f(X,K),p(X)[k(K)],L); .print(L).
-!t4[error(E)] <- .print("failed ",E).
+!t5 <- G = g(1)[k]; G == g(1); .print(no).
-!t5[error(E)] <- .print("failed ",E).
+!t6 <- G = g(1)[k]; G = g(1); .print(yes).
-!t6[error(E)] <- .print("failed ",E).
+!t7 <- g(1) = g(1)[k]; .print(yes).
-!t7[error(E)] <- .print("failed ",E).
+!t8 <- g(1)[k] = g(1); .print(no).
-!t8[error(E)] <- .print("failed ",E).
+!t9 <- g(1)[k] == g(1)[k]; .print(yes).
-!t9[error(E)] <- .print("failed ",E).
+!t10 <- g(1)[a,b] == g(1)[b,a]; .print(yes).
-!t10[error(E)] <- .print("failed ",E).
+!t11 <- +q(1)[s(1)]; +q(1)[s(2)]; ?q(1)[s(1)]; ?q(1)[s(2)]; .print(both).
-!t11[error(E)] <- .print("failed ",E).
+!t12 <- +q(5)[s(1)]; -q(5)[s(1)]; .count(q(5),N); .print(N).
-!t12[error(E)] <- .print("failed ",E).
+!t13 <- +q(6)[s(1),source(ann)]; -q(6); .count(q(6),N); .print(N); -q(6)[source(ann)]; .count(q(6),M); .print(M).
-!t13[error(E)] <- .print("failed ",E).
+!t14 <- +bev(1)[t(3)]; .wait(30).
-!t14[error(E)] <- .print("failed ",E).
+!t15 <- !ga[err(1)].
-!t15[error(E)] <- .print("failed ",E).
+!t16 <- !gb.
-!t16[error(E)] <- .print("failed ",E).
+!t17 <- !gc(1)[z].
-!t17[error(E)] <- .print("failed ",E).
+!t18 <- !dl; .print(on).
-!t18[error(E)] <- .print("failed ",E).
+!t19 <- !dl2; .print(on).
-!t19[error(E)] <- .print("failed ",E).
+!t20 <- !dl3; .print(on).
-!t20[error(E)] <- .print("failed ",E).
+!t21 <- .abolish(p(_)[k(1)]); .findall(X,p(X),L); .print(L).
-!t21[error(E)] <- .print("failed ",E).
+!t22 <- +r(1); +r(2)[source(z)]; .abolish(r(_)[source(z)]); .findall(X,r(X),L); .print(L).
-!t22[error(E)] <- .print("failed ",E).
+!t23 <- +v(1); +v(2); .abolish(v(X)); .count(v(_),N); .print(N,X).
-!t23[error(E)] <- .print("failed ",E).
+!t24 <- X = a; .concat("",X,S); .print(S); .term2string(X,T); .print(T).
-!t24[error(E)] <- .print("failed ",E).
+!t25 <- +s("str"); ?s(X); .string(X); .print(X).
-!t25[error(E)] <- .print("failed ",E).
+!t26 <- X = "a\nb"; .length(X,N); .print(N).
-!t26[error(E)] <- .print("failed ",E).
+!t27 <- .print("x=",3/2," y=",7 mod 2," z=",-1).
-!t27[error(E)] <- .print("failed ",E).
+!t28 <- X = 5; Y = X - 3 - 1; .print(Y); Z = 2*3+4; .print(Z); W = 2+3*4; .print(W); V = (2+3)*4; .print(V).
-!t28[error(E)] <- .print("failed ",E).
+!t29 <- X = 10 div 3 * 2; .print(X); Y = 2 ** 3 ** 2; .print(Y); Z = -2 ** 2; .print(Z).
-!t29[error(E)] <- .print("failed ",E).
+!t30 <- X = 7.5 mod 2; .print(X); Y = 7.9 div 2; .print(Y).
-!t30[error(E)] <- .print("failed ",E).
+!t31 <- X = 1e3; .print(X); Y = 1.5e-3; .print(Y); Z = 123456789012; .print(Z); W = 0.1; .print(W).
-!t31[error(E)] <- .print("failed ",E).
+!t32 <- X = 1/0; .print(X).
-!t32[error(E)] <- .print("failed ",E).
+!t33 <- X = 0/0; .print(X).
-!t33[error(E)] <- .print("failed ",E).
+!t34 <- 1 < 2; 2 <= 2; 3 >= 3; 1 \== 2; .print(cmp).
-!t34[error(E)] <- .print("failed ",E).
+!t35 <- "a" < "b"; .print(s); "a" == "a"; .print(s2).
-!t35[error(E)] <- .print("failed ",E).
+!t36 <- a < b(1); .print(ok).
-!t36[error(E)] <- .print("failed ",E).
+!t37 <- .wait(p(2) & p(X)); .print(X).
-!t37[error(E)] <- .print("failed ",E).
+!t38 <- .wait({-gone(X)},200); .print(X).
-!t38[error(E)] <- .print("failed ",E).
+!t39 <- .wait("-!nothing",30); .print(no).
-!t39[error(E)] <- .print("failed ",E).
+!t40 <- !!sl; .wait({+fin}); .print(fin).
-!t40[error(E)] <- .print("failed ",E).
+!t41 <- .suspended(go,X); .print(no).
-!t41[error(E)] <- .print("failed ",E).
+!t42 <- !!ss; .wait(20); .suspend(ss); .suspended(ss,R); .print(susp); .resume(ss); .wait(50); .print(ok).
-!t42[error(E)] <- .print("failed ",E).
+!t43 <- .desire(ga); .print(no).
-!t43[error(E)] <- .print("failed ",E).
+!t44 <- !!dd(1); .desire(dd(X)); .print(X); .drop_desire(dd(_)); .wait(30); .print(ok).
-!t44[error(E)] <- .print("failed ",E).
+!t45 <- !!dd(2); .drop_event(dd(_)); .wait(30); .print(ok).
-!t45[error(E)] <- .print("failed ",E).
+bev(X)[t(T)] <- .print(X,T).
+!ga <- .fail. -!ga[err(E)] <- .print(E). +!gb <- .fail(mine(1)). -!gb[mine(X),error(E)] <- .print(X,E).
+!gc(X) <- !gd(X). +!gd(X) <- .fail(k(v),error(own)). -!gd(X)[k(V),error(E)] <- .print(X,V,E).
+!dl <- !slow[hard_deadline(40)]; .print(no). -!dl[error(E)] <- .print(E). +!slow <- .wait(200); .print(no).
+!dl2 <- !fast[hard_deadline(400)]; .print(in_time). +!fast <- .wait(10).
+!dl3 <- !slow3[hard_deadline(40)]; .print(handled). +!slow3 <- .wait(200). -!slow3[error(E)] <- .print(E).
+!sl <- .wait(20); +fin. +!ss <- .wait(30); .print(ssdone). +!dd(X) <- .print(no,X).
