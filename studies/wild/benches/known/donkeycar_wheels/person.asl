// The road that a car with two driven wheels follows with its trained model: hard turns make it predict values around 1.
@once  +!visit : one_lap  <- !lap.
@twice +!visit : two_laps <- !lap; !lap.
@winds +!lap : winds       <- predict(soft); predict(right); predict(left).
@right +!lap : turns_right <- predict(right); predict(soft).
@left  +!lap : turns_left  <- predict(left); predict(soft).
@fast  +!lap : is_straight <- predict(full); predict(soft).
