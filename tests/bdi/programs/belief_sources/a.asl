!go.
+!go <- .send(b,tell,hot); .send(b,tell,cold(3)); .send(b,untell,hot); .send(b,achieve,report(now)).
