// Lets a vacuum robot drive and sing from a program; a song may have too many notes, and an answer too few bytes.
@once  +!visit : one_drive  <- !act.
@twice +!visit : two_drives <- !act; !act.
@drives +!act : drives      <- drive(fast); drive(back).
@long   +!act : sings_long  <- sing(long).
@wrong  +!act : sings_wrong <- sing(wrong).
@looks  +!act : looks       <- look(short); drive(back).
