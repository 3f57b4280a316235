"""Schedules: other orders of the code's nodes, threads and callbacks than the usual one, as parameters of tests."""
