p(1). p(2). p(3).
!run.
+!run <- .print("#0"); !t0; .print("#1"); !t1; .print("#2"); !t2; .print("#3"); !t3; .print("#4"); !t4; .print("#5"); !t5; .print("#6"); !t6; .print("#7"); !t7; .print("#8"); !t8; .print("#9"); !t9; .print("#10"); !t10; .print("#11"); !t11; .print("#12"); !t12; .print("#13"); !t13; .print("#14"); !t14; .print("#15"); !t15; .print("#16"); !t16; .print("#17"); !t17; .print("#18"); !t18; .print("#19"); !t19; .print("#20"); !t20; .print("#21"); !t21; .print("#22"); !t22; .print("#23"); !t23; .print("#24"); !t24; .print("#25"); !t25; .print("#26"); !t26; .print("#27"); !t27; .print("#28"); !t28; .print("#29"); !t29; .print("#30"); !t30; .print("#31"); !t31; .print("#32"); !t32; .print("#33"); !t33; .print("#34"); !t34; .print("#end").
+!t0 <- X = math.std_dev([1,2,3,4]); .print(X).
-!t0[error(E)] <- .print("failed ",E).
+!t1 <- .send(a,askOne,p(X),A); .print(A).
-!t1[error(E)] <- .print("failed ",E).
+!t2 <- .send(a,askAll,p(_),A); .print(A).
-!t2[error(E)] <- .print("failed ",E).
+!t3 <- .send(a,tell,[u(1),u(2)]); .wait(200); .findall(X-0,u(X),L); .print(L).
-!t3[error(E)] <- .print("failed ",E).
+!t4 <- .term2string(X,"~p(1)[a]"); .print(X).
-!t4[error(E)] <- .print("failed ",E).
+!t5 <- .term2string(X,"[1,b|T]"); .print(X).
-!t5[error(E)] <- .print("failed ",E).
+!t6 <- .term2string(X,"Y"); .print(ok).
-!t6[error(E)] <- .print("failed ",E).
+!t7 <- .term2string(X,"{ +!g <- a }"); .print(X).
-!t7[error(E)] <- .print("failed ",E).
+!t8 <- .term2string(X,"\"q\""); .string(X); .print(X).
-!t8[error(E)] <- .print("failed ",E).
+!t9 <- .nth(1.5,[a,b,c],X); .print(X).
-!t9[error(E)] <- .print("failed ",E).
+!t10 <- .sort([b,"a",1,c(1),[z],-1,a],L); .print(L).
-!t10[error(E)] <- .print("failed ",E).
+!t11 <- .setof(X,.member(X,[c,a,b,a]),L); .print(L).
-!t11[error(E)] <- .print("failed ",E).
+!t12 <- .findall(X,p(X),[A|B]); .print(A,B).
-!t12[error(E)] <- .print("failed ",E).
+!t13 <- .concat("a",X,R); .print(R).
-!t13[error(E)] <- .print("failed ",E).
+!t14 <- .suspend(nothing); .print(ok).
-!t14[error(E)] <- .print("failed ",E).
+!t15 <- .send(a,askHow,{+!sub2(_)},P); .length(P,N); .print(N).
-!t15[error(E)] <- .print("failed ",E).
+!t16 <- .substring("a","ba",0); .print(y).
-!t16[error(E)] <- .print("failed ",E).
+!t17 <- .length(X,3); .print(X).
-!t17[error(E)] <- .print("failed ",E).
+!t18 <- .max(["b","a"],X); .print(X).
-!t18[error(E)] <- .print("failed ",E).
+!t19 <- .union([b,a,b],[],L); .print(L).
-!t19[error(E)] <- .print("failed ",E).
+!t20 <- .intersection([b,a,b],[b],L); .print(L).
-!t20[error(E)] <- .print("failed ",E).
+!t21 <- .difference([b,a,b,c],[a],L); .print(L).
-!t21[error(E)] <- .print("failed ",E).
+!t22 <- .send(a,askOne,p(X),p(2)); .print(X).
-!t22[error(E)] <- .print("failed ",E).
+!t23 <- .send(a,askOne,p(X),p(1)); .print(X).
-!t23[error(E)] <- .print("failed ",E).
+!t24 <- .send(a,askOne,p(X),p(Y)[source(S)]); .print(X,Y,S).
-!t24[error(E)] <- .print("failed ",E).
+!t25 <- .send(a,tell,tt(X)); .wait(100); ?tt(Z); .print(Z).
-!t25[error(E)] <- .print("failed ",E).
+!t26 <- .send(a,untell,p(1)); .wait(100); .count(p(_),N); .print(N).
-!t26[error(E)] <- .print("failed ",E).
+!t27 <- .send(a,achieve,qq(3)); .wait(100).
-!t27[error(E)] <- .print("failed ",E).
+!t28 <- .send(a,unachieve,qq(3)); .wait(100); .print(ok).
-!t28[error(E)] <- .print("failed ",E).
+!t29 <- .send(a,tellHow,{+!th(X) <- .print(th,X)}); .wait(100); !th(1).
-!t29[error(E)] <- .print("failed ",E).
+!t30 <- .send(a,tell,~neg(1)); .wait(100); ?~neg(X)[source(S)]; .print(X,S).
-!t30[error(E)] <- .print("failed ",E).
+!t31 <- .send(a,tell,an(1)[k(2)]); .wait(100); ?an(1)[k(K)]; .print(K).
-!t31[error(E)] <- .print("failed ",E).
+!t32 <- .send(a,signal,sg(1)); .wait(100); .print(ok).
-!t32[error(E)] <- .print("failed ",E).
+!t33 <- .broadcast(tell,bcc(1)); .wait(100); ?bcc(X); .print(X).
-!t33[error(E)] <- .print("failed ",E).
+!t34 <- .my_name(N); .send(N,tell,me); .wait(100); ?me; .print(ok).
-!t34[error(E)] <- .print("failed ",E).
+!sub2(X) <- true.
+!qq(X)[source(S)] <- .print(qq,X,S).
+sg(X)[source(S)] <- .print(sg,X,S).
