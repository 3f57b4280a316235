// Holds a small leader arm, which a large one follows: to its left or its right, or far from where the large one is.
@left  +!visit : begins_left  <- !arm; hold(left); start.
@right +!visit : begins_right <- !arm; hold(right); start.
@far   +!visit : begins_far   <- !arm; hold(far); start.
@slow  +!arm : slow  <- arm(slow).
@quick +!arm : quick <- arm(quick).
