// Flies a small drone by hand from a program: ends early, goes too low, interrupts, flies again.
@once  +!visit : one_flight  <- !flight.
@twice +!visit : two_flights <- !flight; !flight.
@box   +!flight : box    <- take_off; forward; left; land.
@low   +!flight : low    <- take_off; down; land.
@deep  +!flight : deep   <- take_off; down; down; land.
@still +!flight : still  <- take_off; stay; land.
@drift +!flight : drift  <- take_off; start_forward; stay; land.
@twist +!flight : double <- take_off; take_off; land; land.
