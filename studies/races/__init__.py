"""Twelve small robots, each with a race planted in it, and its repaired twin: what a search of schedules finds.

Each module in `robots` has a class `Robot`, with the race, and `Repaired`. `bench` is the testbench of all of them.

The robots were written before the search was tuned. Five of them are held out, nothing is ever tuned on them:
late_cancel, lost_wake_up, reentrant_group, stale_cache and watchdog_reset.
"""
