// Plays with a small robot from a program: lets it drive for a while, spin, lift, and stop.
@once  +!visit : one_game  <- !play.
@twice +!visit : two_games <- !play; rest; !play.
@drives +!play : drives <- drive(ahead); rest.
@spins  +!play : spins  <- drive(spin); drive(ahead).
@lifts  +!play : lifts  <- lift; rest; stop.
@stops  +!play : stops  <- stop; rest.
