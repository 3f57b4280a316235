p(1). p(2). p(3).
!run.
+!run <- .print("#0"); !t0; .print("#1"); !t1; .print("#2"); !t2; .print("#3"); !t3; .print("#4"); !t4; .print("#5"); !t5; .print("#6"); !t6; .print("#7"); !t7; .print("#8"); !t8; .print("#9"); !t9; .print("#10"); !t10; .print("#11"); !t11; .print("#12"); !t12; .print("#13"); !t13; .print("#14"); !t14; .print("#15"); !t15; .print("#16"); !t16; .print("#17"); !t17; .print("#18"); !t18; .print("#19"); !t19; .print("#20"); !t20; .print("#21"); !t21; .print("#22"); !t22; .print("#23"); !t23; .print("#24"); !t24; .print("#25"); !t25; .print("#26"); !t26; .print("#27"); !t27; .print("#28"); !t28; .print("#29"); !t29; .print("#30"); !t30; .print("#31"); !t31; .print("#32"); !t32; .print("#33"); !t33; .print("#34"); !t34; .print("#35"); !t35; .print("#36"); !t36; .print("#37"); !t37; .print("#38"); !t38; .print("#39"); !t39; .print("#40"); !t40; .print("#41"); !t41; .print("#42"); !t42; .print("#43"); !t43; .print("#44"); !t44; .print("#45"); !t45; .print("#46"); !t46; .print("#47"); !t47; .print("#48"); !t48; .print("#49"); !t49; .print("#50"); !t50; .print("#51"); !t51; .print("#52"); !t52; .print("#53"); !t53; .print("#54"); !t54; .print("#55"); !t55; .print("#56"); !t56; .print("#57"); !t57; .print("#58"); !t58; .print("#59"); !t59; .print("#60"); !t60; .print("#61"); !t61; .print("#62"); !t62; .print("#63"); !t63; .print("#64"); !t64; .print("#65"); !t65; .print("#66"); !t66; .print("#end").
+!t0 <- !sub2(R); .print(R).
-!t0[error(E)] <- .print("failed ",E).
+!t1 <- !sub3(R,S); .print(R,S); R = 1; .print(S).
-!t1[error(E)] <- .print("failed ",E).
+!t2 <- .wait(20,E); .print(E).
-!t2[error(E)] <- .print("failed ",E).
+!t3 <- .wait(p(1),50,E); .print(E).
-!t3[error(E)] <- .print("failed ",E).
+!t4 <- X = math.std_dev([1,2,3,4]); .print(X).
-!t4[error(E)] <- .print("failed ",E).
+!t5 <- X = math.std_dev([5]); .print(X).
-!t5[error(E)] <- .print("failed ",E).
+!t6 <- X = math.median([1,2,3,4]); .print(X).
-!t6[error(E)] <- .print("failed ",E).
+!t7 <- .send(a,askOne,p(X),A); .print(A).
-!t7[error(E)] <- .print("failed ",E).
+!t8 <- .send(a,askAll,p(_),A); .print(A).
-!t8[error(E)] <- .print("failed ",E).
+!t9 <- .send(a,askOne,p(X),p(Y)); .print(Y).
-!t9[error(E)] <- .print("failed ",E).
+!t10 <- .send(a,askOne,zz(X),A); .print(A).
-!t10[error(E)] <- .print("failed ",E).
+!t11 <- .send(a,askAll,zz(X),A); .print(A).
-!t11[error(E)] <- .print("failed ",E).
+!t12 <- .send(a,askOne,p(1)); .wait(30); .findall(S,p(1)[source(S)],L); .print(L).
-!t12[error(E)] <- .print("failed ",E).
+!t13 <- .broadcast(tell,bc); .wait(20); ?bc; .print(no).
-!t13[error(E)] <- .print("failed ",E).
+!t14 <- .send(a,achieve,fromself); .wait(30); .print(ok).
-!t14[error(E)] <- .print("failed ",E).
+!t15 <- .send("a",tell,sname); .wait(20); ?sname; .print(ok).
-!t15[error(E)] <- .print("failed ",E).
+!t16 <- .send(a,askHow,{+!sub2(_)},P); .length(P,N); .print(N).
-!t16[error(E)] <- .print("failed ",E).
+!t17 <- .suspend(nothing); .print(ok).
-!t17[error(E)] <- .print("failed ",E).
+!t18 <- .resume(nothing); .print(ok).
-!t18[error(E)] <- .print("failed ",E).
+!t19 <- .succeed_goal(nothing); .print(ok).
-!t19[error(E)] <- .print("failed ",E).
+!t20 <- .drop_all_desires; .print(ok).
-!t20[error(E)] <- .print("failed ",E).
+!t21 <- .count(p(X),2); .print(no).
-!t21[error(E)] <- .print("failed ",E).
+!t22 <- .findall(X,p(X),[A|B]); .print(A,B).
-!t22[error(E)] <- .print("failed ",E).
+!t23 <- .findall(X,(p(X) & X > 1),L); .print(L).
-!t23[error(E)] <- .print("failed ",E).
+!t24 <- .findall(X,(p(X) & not X = 1),L); .print(L).
-!t24[error(E)] <- .print("failed ",E).
+!t25 <- .setof(X,.member(X,[c,a,b,a]),L); .print(L).
-!t25[error(E)] <- .print("failed ",E).
+!t26 <- .sort([b,"a",1,c(1),[z],-1,a],L); .print(L).
-!t26[error(E)] <- .print("failed ",E).
+!t27 <- .max(["b","a"],X); .print(X).
-!t27[error(E)] <- .print("failed ",E).
+!t28 <- .nth(0,[],X); .print(no).
-!t28[error(E)] <- .print("failed ",E).
+!t29 <- .nth(1.5,[a,b,c],X); .print(X).
-!t29[error(E)] <- .print("failed ",E).
+!t30 <- .nth("1",[a,b,c],X); .print(X).
-!t30[error(E)] <- .print("failed ",E).
+!t31 <- .nth(a,[a,b,c],X); .print(X).
-!t31[error(E)] <- .print("failed ",E).
+!t32 <- .length(X,3); .print(X).
-!t32[error(E)] <- .print("failed ",E).
+!t33 <- .length("",N); .print(N).
-!t33[error(E)] <- .print("failed ",E).
+!t34 <- .concat([],[],L); .print(L).
-!t34[error(E)] <- .print("failed ",E).
+!t35 <- .concat("a",X,R); .print(R).
-!t35[error(E)] <- .print("failed ",E).
+!t36 <- .reverse([],L); .print(L).
-!t36[error(E)] <- .print("failed ",E).
+!t37 <- .member(X,a); .print(no).
-!t37[error(E)] <- .print("failed ",E).
+!t38 <- .member(X,[]); .print(no).
-!t38[error(E)] <- .print("failed ",E).
+!t39 <- .member([X],[[1],2,[3]]); .print(X).
-!t39[error(E)] <- .print("failed ",E).
+!t40 <- .sublist([X,b],[a,b,c]); .print(X).
-!t40[error(E)] <- .print("failed ",E).
+!t41 <- .prefix([a|T],[a,b,c]); .print(T).
-!t41[error(E)] <- .print("failed ",E).
+!t42 <- .suffix(S,[a]); .print(S).
-!t42[error(E)] <- .print("failed ",E).
+!t43 <- .union([b,a,b],[],L); .print(L).
-!t43[error(E)] <- .print("failed ",E).
+!t44 <- .intersection([a,b],[],L); .print(L).
-!t44[error(E)] <- .print("failed ",E).
+!t45 <- .difference([b,a,b],[a],L); .print(L).
-!t45[error(E)] <- .print("failed ",E).
+!t46 <- .union("ab",[b],L); .print(L).
-!t46[error(E)] <- .print("failed ",E).
+!t47 <- .shuffle([a],L); .print(L).
-!t47[error(E)] <- .print("failed ",E).
+!t48 <- .atom(p); .print(y1); .atom([]); .print(y2).
-!t48[error(E)] <- .print("failed ",E).
+!t49 <- .list([a|T]); .print(y).
-!t49[error(E)] <- .print("failed ",E).
+!t50 <- .list(X); .print(y).
-!t50[error(E)] <- .print("failed ",E).
+!t51 <- .literal([a]); .print(y).
-!t51[error(E)] <- .print("failed ",E).
+!t52 <- .literal(X); .print(y).
-!t52[error(E)] <- .print("failed ",E).
+!t53 <- .string("a"); .print(y).
-!t53[error(E)] <- .print("failed ",E).
+!t54 <- .ground([a,X]); .print(y).
-!t54[error(E)] <- .print("failed ",E).
+!t55 <- .ground(X); .print(y).
-!t55[error(E)] <- .print("failed ",E).
+!t56 <- .structure("a"); .print(y).
-!t56[error(E)] <- .print("failed ",E).
+!t57 <- .structure(X); .print(y).
-!t57[error(E)] <- .print("failed ",E).
+!t58 <- .number(X); .print(y).
-!t58[error(E)] <- .print("failed ",E).
+!t59 <- .substring("a","ba",0); .print(y).
-!t59[error(E)] <- .print("failed ",E).
+!t60 <- .substring("a","aaa",P) ; .print(P).
-!t60[error(E)] <- .print("failed ",E).
+!t61 <- .substring(a,"bab"); .print(y).
-!t61[error(E)] <- .print("failed ",E).
+!t62 <- .term2string(X,"f(Y,Z)"); X = f(1,2); .print(X).
-!t62[error(E)] <- .print("failed ",E).
+!t63 <- .term2string(a[b],S); .print(S).
-!t63[error(E)] <- .print("failed ",E).
+!t64 <- .term2string([1,"x"],S); .print(S).
-!t64[error(E)] <- .print("failed ",E).
+!t65 <- .term2string("q",S); .print(S).
-!t65[error(E)] <- .print("failed ",E).
+!t66 <- .abolish(p(1)[source(self)]); .count(p(_),N); .print(N).
-!t66[error(E)] <- .print("failed ",E).
+!sub2(X) <- true.
+!sub3(X,X) <- true.
+!sub4(X,Y) <- X = f(Y).
+!bg <- .print(bg1); .wait(30); .print(bg2).
-!bg <- .print(bgfailed).
-!bgo <- .print(bgofailed).
+!fromself[source(S)] <- .print(fs,S).
