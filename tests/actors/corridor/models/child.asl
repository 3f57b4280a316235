// A child that plays in the corridor.
@playful +!play : playful <- step_in; !stay; step_out.
@shy     +!play : shy     <- wait.

@listens +!stay : watchful <- .wait({+warned}, 5000, _).
@dreams  +!stay <- wait.
