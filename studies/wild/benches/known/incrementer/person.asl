// Moves a robot's spine step by step with a joystick, with rests between the steps or without.
@once  +!visit : one_move  <- !part.
@twice +!visit : two_moves <- !part; !part.
@calm  +!part : calm  <- move; rest; move.
@hasty +!part : hasty <- move; move.
