!go.
+!go <- .broadcast(tell,hello); .wait(100); .send(b,askAll,item(_),L); .print(L); .send([b,c],achieve,say(bye)).
