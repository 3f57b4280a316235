"""Small robots, each with a race planted in it, and its repaired twin: what a search of schedules finds.

Each module in `robots` has a class `Robot`, with the race, and `Repaired`. `bench` is the testbench of all of them.

The robots were written by somebody who had not read the search, and before it was tuned. Eight of them are held out,
nothing is ever tuned on them: wiper_modes, order_list, goal_table, lazy_driver, busy_arms, contact_timer, shared_goal
and planned_move. Five more were written after the search, of kinds that it had not seen, and are held out, too:
taken_part, cleared_event, second_grip, twice_pressed and shared_steps; on changing_goals, points in loops were tuned.
So are six of the last eight, again by somebody who had not read the search: one_reply, wrong_waiter, even_version,
two_of_three, late_callback and wiped_answer.
"""
