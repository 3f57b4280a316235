// Switches the dog on, walks it with a joystick, switches it off in the middle, and on again; the link may fail.
@once  +!visit : one_walk  <- !walk.
@twice +!visit : two_walks <- !walk; !walk.
@tidy  +!walk : tidy  <- press(l1); press(r1); stick(ahead); stick(zero); press(r1); press(l1).
@hasty +!walk : hasty <- press(l1); press(r1); stick(ahead); press(l1).
@hops  +!walk : hops  <- press(l1); press(x); press(x); press(l1).
@lost  +!walk : lost  <- press(l1); press(r1); link(lost); link(back); press(r1); press(l1).
