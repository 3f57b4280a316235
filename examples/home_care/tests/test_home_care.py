"""The host test: each generated test of the home-care robot becomes one item of it."""

from __future__ import annotations

from pytest_hricdv.custom_tests import HriCase


def test_home_care(hri_case: HriCase) -> None:
    """The real code serves the person in the simulated flat; the monitors watch."""
    hri_case.check(hri_case.run())
