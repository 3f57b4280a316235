// A child that plays in the corridor.
@playful  +!play : playful <- step_in; !stay; step_out.
@shy      +!play <- wait.

@listens  +!stay : watchful <- .wait({+warned}, 5000, _).
@dreams   +!stay <- wait.

+hurried. +watchful. +patient. +playful. +shy. +warned.
