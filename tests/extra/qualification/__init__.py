"""Tests of `pytest_hricdv.extra.qualification`."""
