// Flies a small drone with a program that sends each change of its stick once, and lands it.
@once  +!visit : one_flight  <- !flight.
@twice +!visit : two_flights <- !flight; !flight.
@calm  +!flight : calm   <- push(up); push(ahead); push(zero); push(down); push(zero).
@hasty +!flight : hasty  <- push(left); push(down); push(zero).
@idle  +!flight : idle   <- push(zero); push(down); push(zero).
@leave +!flight : leaves <- push(ahead); leave.
