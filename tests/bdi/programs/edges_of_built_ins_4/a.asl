p(1). p(2). p(3). q(a)[source(bob),deg(1)]. q(b)[source(ann)]. ~neg(x). item(box,2.5). item(cup,1). lst([1,2,3]). str("hi").
!run.
+!run <- .print("#0"); !t0; .print("#1"); !t1; .print("#2"); !t2; .print("#3"); !t3; .print("#4"); !t4; .print("#5"); !t5; .print("#6"); !t6; .print("#7"); !t7; .print("#8"); !t8; .print("#9"); !t9; .print("#10"); !t10; .print("#11"); !t11; .print("#12"); !t12; .print("#13"); !t13; .print("#14"); !t14; .print("#15"); !t15; .print("#16"); !t16; .print("#17"); !t17; .print("#18"); !t18; .print("#19"); !t19; .print("#20"); !t20; .print("#21"); !t21; .print("#22"); !t22; .print("#23"); !t23; .print("#24"); !t24; .print("#25"); !t25; .print("#26"); !t26; .print("#27"); !t27; .print("#28"); !t28; .print("#29"); !t29; .print("#30"); !t30; .print("#31"); !t31; .print("#32"); !t32; .print("#33"); !t33; .print("#34"); !t34; .print("#35"); !t35; .print("#36"); !t36; .print("#37"); !t37; .print("#38"); !t38; .print("#39"); !t39; .print("#40"); !t40; .print("#41"); !t41; .print("#42"); !t42; .print("#43"); !t43; .print("#44"); !t44; .print("#45"); !t45; .print("#46"); !t46; .print("#47"); !t47; .print("#48"); !t48; .print("#49"); !t49; .print("#50"); !t50; .print("#51"); !t51; .print("#52"); !t52; .print("#53"); !t53; .print("#54"); !t54; .print("#55"); !t55; .print("#56"); !t56; .print("#57"); !t57; .print("#58"); !t58; .print("#59"); !t59; .print("#60"); !t60; .print("#61"); !t61; .print("#62"); !t62; .print("#63"); !t63; .print("#64"); !t64; .print("#65"); !t65; .print("#66"); !t66; .print("#67"); !t67; .print("#68"); !t68; .print("#69"); !t69; .print("#70"); !t70; .print("#71"); !t71; .print("#72"); !t72; .print("#73"); !t73; .print("#74"); !t74; .print("#75"); !t75; .print("#76"); !t76; .print("#77"); !t77; .print("#78"); !t78; .print("#79"); !t79; .print("#80"); !t80; .print("#81"); !t81; .print("#82"); !t82; .print("#83"); !t83; .print("#84"); !t84; .print("#85"); !t85; .print("#86"); !t86; .print("#87"); !t87; .print("#88"); !t88; .print("#89"); !t89; .print("#90"); !t90; .print("#91"); !t91; .print("#92"); !t92; .print("#93"); !t93; .print("#94"); !t94; .print("#95"); !t95; .print("#end").
+!t0 <- ?p(X); .print(X); -p(X); ?p(Y); .print(Y); +p(X).
-!t0[error(E)] <- .print("failed ",E).
+!t1 <- .abolish(p(2)[source(zz)]); .count(p(_),N); .print(N).
-!t1[error(E)] <- .print("failed ",E).
+!t2 <- -p(99); .print(ok).
-!t2[error(E)] <- .print("failed ",E).
+!t3 <- +p(2); .count(p(_),N); .print(N).
-!t3[error(E)] <- .print("failed ",E).
+!t4 <- -+cur(1); -+cur(2); .findall(X,cur(X),L); .print(L).
-!t4[error(E)] <- .print("failed ",E).
+!t5 <- ?q(X)[source(S)]; .print(X,S).
-!t5[error(E)] <- .print("failed ",E).
+!t6 <- .findall([X,S],q(X)[source(S)],L); .print(L).
-!t6[error(E)] <- .print("failed ",E).
+!t7 <- ?q(a)[deg(D)]; .print(D).
-!t7[error(E)] <- .print("failed ",E).
+!t8 <- ?q(a)[deg(2)]; .print(no).
-!t8[error(E)] <- .print("failed ",E).
+!t9 <- ?~neg(X); .print(X).
-!t9[error(E)] <- .print("failed ",E).
+!t10 <- ?not p(77); .print(ok).
-!t10[error(E)] <- .print("failed ",E).
+!t11 <- ?p(X) & X > 2; .print(X).
-!t11[error(E)] <- .print("failed ",E).
+!t12 <- ?(p(X) | p(Y)); .print(X,Y).
-!t12[error(E)] <- .print("failed ",E).
+!t13 <- .member(X,[1,2,3]) ; X > 1; .print(X).
-!t13[error(E)] <- .print("failed ",E).
+!t14 <- X = 3 + 4 * 2 - 1; .print(X).
-!t14[error(E)] <- .print("failed ",E).
+!t15 <- X = 7 div 2; Y = -7 div 2; Z = 7 mod 3; W = -7 mod 3; .print(X," ",Y," ",Z," ",W).
-!t15[error(E)] <- .print("failed ",E).
+!t16 <- X = 2 ** 10; Y = 2 ** -1; .print(X," ",Y).
-!t16[error(E)] <- .print("failed ",E).
+!t17 <- X = 10 / 4; Y = 1/3; Z = 1e20; W = 123456789; V = 1234567890123; .print(X," ",Y," ",Z," ",W," ",V).
-!t17[error(E)] <- .print("failed ",E).
+!t18 <- X = -(3); Y = - 3 + 1; .print(X,Y).
-!t18[error(E)] <- .print("failed ",E).
+!t19 <- X = "a" ; Y = "b"; X < Y; .print(lt).
-!t19[error(E)] <- .print("failed ",E).
+!t20 <- X = f(Y); Y = 3; .print(X).
-!t20[error(E)] <- .print("failed ",E).
+!t21 <- [H|T] = [1,2,3]; .print(H,T).
-!t21[error(E)] <- .print("failed ",E).
+!t22 <- [A,B|T] = [1,2]; .print(A,B,T).
-!t22[error(E)] <- .print("failed ",E).
+!t23 <- [A|T] = []; .print(no).
-!t23[error(E)] <- .print("failed ",E).
+!t24 <- f(X,b) = f(a,Y); .print(X,Y).
-!t24[error(E)] <- .print("failed ",E).
+!t25 <- f(X) = g(X); .print(no).
-!t25[error(E)] <- .print("failed ",E).
+!t26 <- a == a; .print(ok); f(1) == f(1.0); .print(ok2); "a" == a; .print(no).
-!t26[error(E)] <- .print("failed ",E).
+!t27 <- a \== b; .print(ok); 1 \== 1; .print(no).
-!t27[error(E)] <- .print("failed ",E).
+!t28 <- X == 1; .print(no).
-!t28[error(E)] <- .print("failed ",E).
+!t29 <- X = Y; Y = 2; .print(X).
-!t29[error(E)] <- .print("failed ",E).
+!t30 <- a < b; .print(1); f(a) < g(a); .print(2); "z" < a; .print(3); 3 < "a"; .print(4); [1] < a; .print(5).
-!t30[error(E)] <- .print("failed ",E).
+!t31 <- X =.. [foo,[1,2],[]]; .print(X).
-!t31[error(E)] <- .print("failed ",E).
+!t32 <- X =.. [foo,[1,2],[an]]; .print(X).
-!t32[error(E)] <- .print("failed ",E).
+!t33 <- if (p(1)) { .print(yes) } else { .print(no) }.
-!t33[error(E)] <- .print("failed ",E).
+!t34 <- if (p(50)) { .print(yes) } else { if (p(2)) { .print(inner) } }.
-!t34[error(E)] <- .print("failed ",E).
+!t35 <- while (cnt(N) & N < 3) { -+cnt(N+1) }; .print(end).
-!t35[error(E)] <- .print("failed ",E).
+!t36 <- +cnt(0); while (cnt(N) & N < 3) { .print(N); -+cnt(N+1) }; ?cnt(Z); .print(Z).
-!t36[error(E)] <- .print("failed ",E).
+!t37 <- for (p(X)) { .print(X) }; .print(X).
-!t37[error(E)] <- .print("failed ",E).
+!t38 <- for (.range(I,1,3)) { .print(I) }.
-!t38[error(E)] <- .print("failed ",E).
+!t39 <- for (.member(X,[a,b])) { for (.member(Y,[1,2])) { .print(X,Y) } }.
-!t39[error(E)] <- .print("failed ",E).
+!t40 <- for (p(X) & X > 1) { +seen(X) }; .findall(S,seen(S),L); .print(L).
-!t40[error(E)] <- .print("failed ",E).
+!t41 <- !sub(3,R); .print(R).
-!t41[error(E)] <- .print("failed ",E).
+!t42 <- !sub2(R); .print(R).
-!t42[error(E)] <- .print("failed ",E).
+!t43 <- !undefd; .print(no).
-!t43[error(E)] <- .print("failed ",E).
+!t44 <- !failing; .print(no).
-!t44[error(E)] <- .print("failed ",E).
+!t45 <- !failing2; .print(ok).
-!t45[error(E)] <- .print("failed ",E).
+!t46 <- !noctx(5); .print(no).
-!t46[error(E)] <- .print("failed ",E).
+!t47 <- ?gt(X); .print(X).
-!t47[error(E)] <- .print("failed ",E).
+!t48 <- ?unk(X); .print(no).
-!t48[error(E)] <- .print("failed ",E).
+!t49 <- .fail; .print(no).
-!t49[error(E)] <- .print("failed ",E).
+!t50 <- .fail(my(1),"text"); .print(no).
-!t50[error(E)] <- .print("failed ",E).
+!t51 <- true; .print(ok).
-!t51[error(E)] <- .print("failed ",E).
+!t52 <- !!par(1); !!par(2); .wait(50); .print(after).
-!t52[error(E)] <- .print("failed ",E).
+!t53 <- .wait(20,E); .print(no).
-!t53[error(E)] <- .print("failed ",E).
+!t54 <- .wait(p(1)); .print(ok).
-!t54[error(E)] <- .print("failed ",E).
+!t55 <- .wait(p(88),50); .print(no).
-!t55[error(E)] <- .print("failed ",E).
+!t56 <- .wait({+evt(X)},50); .print(no).
-!t56[error(E)] <- .print("failed ",E).
+!t57 <- .wait("+evt(7)",30,T); .number(T); .print(ok).
-!t57[error(E)] <- .print("failed ",E).
+!t58 <- !later; .wait({+evt(X)}); .print(X).
-!t58[error(E)] <- .print("failed ",E).
+!t59 <- .concat("x=",1.50,";",f("q"),";",[a,"b"],Z); .print(Z).
-!t59[error(E)] <- .print("failed ",E).
+!t60 <- .print("a","b",c,1,"x y",[1,"s"],f("t")).
-!t60[error(E)] <- .print("failed ",E).
+!t61 <- .print; .print(end).
-!t61[error(E)] <- .print("failed ",E).
+!t62 <- .print(X).
-!t62[error(E)] <- .print("failed ",E).
+!t63 <- .print(_).
-!t63[error(E)] <- .print("failed ",E).
+!t64 <- .println("x"); .print(y).
-!t64[error(E)] <- .print("failed ",E).
+!t65 <- .print(1.0," ",2.50," ",1e-5," ",1e7," ",12345678.9," ",1.0E10).
-!t65[error(E)] <- .print("failed ",E).
+!t66 <- .print(~a," ",a[b,c]," ",[]).
-!t66[error(E)] <- .print("failed ",E).
+!t67 <- .print(1+2," ",3-1*2).
-!t67[error(E)] <- .print("failed ",E).
+!t68 <- .date(Y,M,D); .number(Y); .print(ok).
-!t68[error(E)] <- .print("failed ",E).
+!t69 <- .time(H,M,S); .number(H); .print(ok).
-!t69[error(E)] <- .print("failed ",E).
+!t70 <- X = math.round(2.5); Y = math.round(-2.5); Z = math.floor(-1.5); W = math.ceil(1.2); .print(X," ",Y," ",Z," ",W).
-!t70[error(E)] <- .print("failed ",E).
+!t71 <- X = math.max(3,9); Y = math.min([4,2]); Z = math.abs(-3); .print(X,Y,Z).
-!t71[error(E)] <- .print("failed ",E).
+!t72 <- X = math.sqrt(16); Y = math.sum([1,2,3]); Z = math.average([1,2]); .print(X," ",Y," ",Z).
-!t72[error(E)] <- .print("failed ",E).
+!t73 <- X = math.pi; .print(X); Y = math.e; .print(Y).
-!t73[error(E)] <- .print("failed ",E).
+!t74 <- X = .length([1,2]) + 1; .print(X).
-!t74[error(E)] <- .print("failed ",E).
+!t75 <- X = math.std_dev([1,2,3,4]); .print(X); Y = math.median([3,1,2]); .print(Y).
-!t75[error(E)] <- .print("failed ",E).
+!t76 <- .desire(run); .print(yes).
-!t76[error(E)] <- .print("failed ",E).
+!t77 <- .intend(run); .print(yes).
-!t77[error(E)] <- .print("failed ",E).
+!t78 <- .desire(nothing); .print(no).
-!t78[error(E)] <- .print("failed ",E).
+!t79 <- .intend(t95); .print(no).
-!t79[error(E)] <- .print("failed ",E).
+!t80 <- !!bg; .wait(20); .drop_intention(bg); .wait(60); .print(ok).
-!t80[error(E)] <- .print("failed ",E).
+!t81 <- !!bg; .wait(20); .drop_desire(bg); .wait(60); .print(ok).
-!t81[error(E)] <- .print("failed ",E).
+!t82 <- !!bg; .wait(20); .succeed_goal(bg); .wait(60); .print(ok).
-!t82[error(E)] <- .print("failed ",E).
+!t83 <- !!bg; .wait(20); .suspend(bg); .wait(60); .resume(bg); .wait(60); .print(ok).
-!t83[error(E)] <- .print("failed ",E).
+!t84 <- .suspended(bg,R); .print(no).
-!t84[error(E)] <- .print("failed ",E).
+!t85 <- .add_plan({+!newp(X) <- .print(newp,X)}); !newp(1).
-!t85[error(E)] <- .print("failed ",E).
+!t86 <- .add_plan("@lbl +!newp2 <- .print(np2).",self,begin); !newp2; .remove_plan(lbl); !newp2; .print(no).
-!t86[error(E)] <- .print("failed ",E).
+!t87 <- .relevant_plans({+!sub(_,_)},L); .length(L,N); .print(N).
-!t87[error(E)] <- .print("failed ",E).
+!t88 <- .plan_label(P,lblx); .print(yes).
-!t88[error(E)] <- .print("failed ",E).
+!t89 <- .send(a,tell,hey(1)); .wait(30); ?hey(X)[source(S)]; .print(X,S).
-!t89[error(E)] <- .print("failed ",E).
+!t90 <- .send(a,achieve,par(9)); .wait(30).
-!t90[error(E)] <- .print("failed ",E).
+!t91 <- .send(a,askOne,p(X),A); .print(A).
-!t91[error(E)] <- .print("failed ",E).
+!t92 <- .send(a,askAll,p(_),A); .print(A).
-!t92[error(E)] <- .print("failed ",E).
+!t93 <- .send(nobody,tell,x); .print(no).
-!t93[error(E)] <- .print("failed ",E).
+!t94 <- .send(a,untell,hey(1)); .wait(30); ?hey(1); .print(no).
-!t94[error(E)] <- .print("failed ",E).
+!t95 <- .my_name(a); .print(yes).
-!t95[error(E)] <- .print("failed ",E).
+!sub(X,Y) <- Y = X * 2.
+!sub2(X) <- true.
+!failing <- .print(f); .fail; .print(no).
+!failing2 <- .fail. -!failing2[error(E),error_msg(M),code(C)] <- .print(E,"|",M,"|",C).
+!noctx(X) : X < 3 <- .print(no).
+?gt(X) <- X = 42.
+!par(X) <- .print(par1,X); .print(par2,X).
+!later <- !!l2. +!l2 <- .wait(10); +evt(3).
+!bg <- .print(bg1); .wait(30); .print(bg2).
-!bg <- .print(bgfailed).
@lblx +!labelled <- true.
