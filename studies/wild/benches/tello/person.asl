// Flies a small drone with a program over a wireless link that loses answers, is slow, or garbles a packet.
@once  +!visit : one_flight  <- !flight.
@twice +!visit : two_flights <- !flight; !flight.
@fine     +!flight : fine     <- takeoff; stay; move_forward; height; rotate_clockwise; land.
@lossy    +!flight : lossy    <- takeoff; link(loses); move_forward; link(good); land.
@sluggish +!flight : sluggish <- takeoff; link(slow); move_forward; link(good); stay; rotate_clockwise; land.
@noisy    +!flight : noisy    <- takeoff; link(garbled); stay; link(good); height; height; land.
