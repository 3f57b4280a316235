// Flies a small drone from a program: along a square, to a point where it is already, and back.
@once  +!visit : one_flight  <- !flight.
@twice +!visit : two_flights <- !flight; !flight.
@square  +!flight : square  <- up; forward; go_to(aside).
@stays   +!flight : stays   <- go_to(low); stay; go_to(low); stay.
@returns +!flight : returns <- go_to(aside); stay; go_to(here); go_to(low).
