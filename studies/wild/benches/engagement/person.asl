// Looks at a robot and talks with it; then looks off, turns round so that its face is not seen, steps back, or leaves.
@once  +!visit : one_talk  <- !talk.
@twice +!visit : two_talks <- !talk; !talk.
@off   +!talk : looks_off <- look(at_robot); look(away).
@turn  +!talk : turns     <- look(at_robot); turn_around.
@walk  +!talk : walks_off <- look(at_robot); leave.
@back  +!talk : backs_off <- look(at_robot); look(from_afar).
@talk  +!talk <- look(at_robot).
