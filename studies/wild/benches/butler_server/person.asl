// Orders food, confirms at the kitchen and at the table or not, cancels meanwhile, and orders again.
@once  +!visit : one_order  <- !order.
@twice +!visit : two_orders <- !order; wait_result; !order.
@hasty +!visit : overlaps   <- !order; !order.
@table  +!order : one_table   & polite <- order(one); wait; confirm; wait; confirm.
@tables +!order : both_tables & polite <- order(both); wait; confirm; wait; confirm; wait; confirm.
@absent +!order : one_table   & leaves <- order(one); wait.
@cancel +!order : one_table   & changes_mind <- order(one); wait; cancel(all).
@late   +!order : both_tables & changes_mind <- order(both); wait; confirm; wait; cancel(one).
@gone   +!order <- order(both); wait; confirm.
