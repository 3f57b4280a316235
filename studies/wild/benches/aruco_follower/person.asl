// Carries a marker in front of a rover: far, near, to its left, close beside it; hides it, with clocks that differ; later, odometry comes.
@once  +!visit : one_walk  <- !walk; !part.
@twice +!visit : two_walks <- !walk; !walk; !part.
@near  +!walk : comes_near <- walk(far); walk(near).
@aside +!walk : aside      <- walk(left).
@pass  +!walk : passes     <- walk(middle); walk(beside).
@ahead +!walk <- walk(far).
@hide  +!part : hides      <- walk(far); hide.
@late  +!part : hides_late <- clock_ahead; walk(far); hide.
@wheels +!part : odometry <- odometry_comes; walk(far).
@stand +!part <- walk(middle).
