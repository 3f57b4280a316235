// Flies a small drone by hand from a program, lands it, and flies again.
@once  +!visit : one_flight  <- !flight.
@twice +!visit : two_flights <- !flight; stay; !flight.
@box   +!flight : box    <- take_off; forward; left; land.
@low   +!flight : low    <- take_off; down; land.
@still +!flight : still  <- take_off; stay; land.
@drift +!flight : drift  <- take_off; start_forward; stay; land.
