// The nurse at the ward's desk.
@hurried  +!work : hurried  <- send_on; rest.
@watchful +!work : watchful <- rest; call_out; .send(child, tell, warned); rest.
@patient  +!work <- rest.
