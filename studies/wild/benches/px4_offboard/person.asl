// The pilot arms, hands over to the program, takes back, and hands over again; the radio link may fail.
@once  +!visit : one_flight  <- arm; !flight; disarm.
@twice +!visit : two_flights <- arm; !flight; take_back; !flight; disarm.
@early +!visit : not_armed   <- !flight; take_back.
@short  +!flight : short  <- hand_over(short).
@long   +!flight : long   <- hand_over(long).
@silent +!flight : silent <- hand_over(short); link_fails; link_returns.
