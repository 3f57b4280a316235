// Drives a base with the arrow keys of a keyboard: holds one, holds one after another, or taps it.
@once  +!visit : one_drive  <- !drive.
@twice +!visit : two_drives <- !drive; rest; !drive.
@straight +!drive : straight <- hold(up); rest; hold(down).
@turns    +!drive : turns    <- hold(left); rest; hold(right).
@taps     +!drive : taps     <- tap(up); rest; tap(up).
