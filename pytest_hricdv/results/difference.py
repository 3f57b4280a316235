"""A difference of a run from its baseline, as a record of `report.json`."""

from __future__ import annotations

from pytest_hricdv._base.record import Names, PlainRecord


class Difference(PlainRecord, frozen=True, kw_only=True):
    """What a suite reached otherwise than in the baseline.

    Args:
        suite: of the run.
        what: for instance "R3 violated by", "statements" or "bins of handover".
        before: in the baseline, as a number with its unit.
        now: in this run, likewise.
        items: the tests, plans or bins that came or went; empty where it is about a number only.
        worse: it fails the session; otherwise it is better.
        text: the same as a sentence, with the first items only.
    """

    suite: str
    what: str
    before: str
    now: str
    items: Names
    worse: bool
    text: str
