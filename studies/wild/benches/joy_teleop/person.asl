// Drives a base with a joystick: holds the dead man's button, lets it go, unplugs the joystick, plugs in another one.
@once  +!visit : one_drive  <- !drive.
@twice +!visit : two_drives <- !drive; !drive.
@holds +!drive : holds    <- hold; push(stick); let_go.
@loose +!drive : forgets  <- push(stick); push(zero).
@cable +!drive : unplugs  <- hold; push(stick); unplug; plug_in(same); let_go.
@small +!drive : replaces <- push(zero); plug_in(small); push(stick); plug_in(same).
