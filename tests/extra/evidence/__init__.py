"""Tests of `pytest_hricdv.extra.evidence`."""
