"""Tests of `pytest_hricdv.extra.schedules`."""
