// The nurse loads the robot and sends it.
@early +!deliver : early <- load; send.
@late  +!deliver : late  <- rest; load; rest; send.
