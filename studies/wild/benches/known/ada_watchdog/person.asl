// Is fed by an arm that has to stop when its sensor of forces fails: its clock is wrong, or somebody pulls its cable.
@meal  +!visit : one_meal  <- !trouble; sensor(works).
@meals +!visit : two_meals <- !trouble; sensor(works); !trouble.
@ahead  +!trouble : ahead  <- sensor(runs_ahead).
@late   +!trouble : late   <- sensor(delays).
@silent +!trouble : silent <- sensor(stops).
