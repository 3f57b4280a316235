// Moves in front of a robot's motion sensor, stands still, and moves again.
@once  +!visit : one_visit  <- !walk.
@twice +!visit : two_visits <- !walk; !walk.
@passes   +!walk : passes   <- move; stand_still.
@stays    +!walk : stays    <- move; stand_still; move; stand_still.
@twitches +!walk : twitches <- stand_still; move; move; stand_still.
