"""Tests of `pytest_hricdv.extra.answers`."""
