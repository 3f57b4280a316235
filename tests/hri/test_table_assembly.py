"""The host test: each generated test of the table assembly becomes one item of it."""

from __future__ import annotations

from pytest_hricdv.custom_tests import HriCase


def test_table_assembly(hri_case: HriCase) -> None:
    """The real controller hands over table legs in the simulated world; the monitors of R1-R5 watch."""
    hri_case.check(hri_case.run())
