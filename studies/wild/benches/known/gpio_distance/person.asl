// Stands in front of a robot's ultrasonic sensor, whose echo loses an edge now and then, and leaves.
@once  +!visit : one_walk  <- stand; !then.
@twice +!visit : two_walks <- stand; !then; step_off; stand; !then.
@rise +!then : rise_lost <- lose(rise); stand.
@fall +!then : fall_lost <- lose(fall); stand.
@both +!then : both_lost <- lose(fall); lose(rise); stand.
@off  +!then : leaves    <- step_off.
