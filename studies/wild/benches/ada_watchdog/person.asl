// Is fed by an arm that has to stop when its sensor of forces fails: somebody pulls its cable, or its clock is wrong.
@meal  +!visit : one_meal  <- !trouble; sensor(works).
@meals +!visit : two_meals <- !trouble; sensor(works); !trouble.
@frozen  +!trouble : frozen  <- sensor(freezes).
@silent  +!trouble : silent  <- sensor(stops).
@invalid +!trouble : invalid <- sensor(invalid).
@stuck   +!trouble : stuck   <- sensor(sticks).
@late    +!trouble : late    <- sensor(delays).
