~open(door). open(window).
!go.
+!go : ~open(door) & not open(door) <- .print("door shut"); -~open(door); +open(door); !check; +~likes(fish); ?~likes(X); .print("not ",X).
+!check : open(door) & not ~open(door) <- .print("door open").
+~likes(X) <- .print("dislikes ",X).
