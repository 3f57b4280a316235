// Lets a robot park in front of a reflecting tape; stands behind it, pulls the cable of its scanner, or has nothing in range.
@early +!visit : early <- !trouble.
@late  +!visit : late  <- wait; !trouble.
@cable  +!trouble : cable         <- scan(stops).
@behind +!trouble : person_behind <- step_behind; step_off.
@free   +!trouble : no_echo       <- scan(free).
@none   +!trouble <- wait.
