// Sends a robot to a place with letters; its way may be blocked, or its dock stuck; leaves at the end.
@once  +!visit : one_letter  <- !send; type(exit).
@twice +!visit : two_letters <- type(place); !send; type(exit).
@fail  +!visit : stuck_dock & refused <- let(undock_refuse); type(place); type(exit).
@stuck +!visit : stuck_dock  <- let(undock_fail); type(place); type(exit).
@refuse +!send : refused <- let(refuse); type(place).
@block  +!send : blocked <- let(abort); type(place).
@typo   +!send : typo    <- type(word); type(place).
@free   +!send <- type(place).
