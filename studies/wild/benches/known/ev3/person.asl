// Drives a toy with two motors: by its joystick, by rotations of its wheels, or to positions, one of which it has already.
@once  +!visit : one_drive  <- !drive.
@twice +!visit : two_drives <- !drive; !drive.
@stick +!drive : stick     <- stick(ahead); stick(centre); stick(aside); stick(centre).
@turn  +!drive : rotations <- turn(ahead); turn(spin).
@go    +!drive : positions <- go_to(there); go_to(here).
