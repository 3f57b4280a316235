// Drives a base with a joystick that has a dead man's button for each hand: holds both, or one, lets one go, forgets them.
@once  +!visit : one_drive  <- !drive.
@twice +!visit : two_drives <- !drive; !drive.
@both  +!drive : holds_both  <- hold(left); hold(right); push(stick); let_go(left); let_go(right); push(zero).
@one   +!drive : holds_one   <- hold(right); push(stick); push(zero); let_go(right).
@goes  +!drive : lets_one_go <- hold(left); hold(right); push(stick); let_go(right); push(zero); let_go(left).
@none  +!drive : forgets     <- push(stick); push(zero).
