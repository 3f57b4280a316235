"""What shrinking a failed test and searching for a violation found, as a report holds it."""

from __future__ import annotations

from typing import Literal

from pytest_hricdv._base.record import Count, Names, NotNegative, Number, PlainRecord

SearchEnd = Literal["done", "runs", "seconds", "interrupted"]
"""Why shrinking or searching ended: nothing left to do, or the budget of runs or seconds was used up, or Ctrl-C."""


class ShrunkTest(PlainRecord, frozen=True, kw_only=True):
    """The shortest test found that fails a requirement for the same reason.

    `id` and `replay` are None where nothing could be removed; `note` says why the test was not shrunk at all.
    """

    id: str | None
    replay: str | None
    abstract: Names
    concrete: Names
    actions_before: Count
    runs: Count
    wall_s: NotNegative
    ended: SearchEnd
    reason: Names
    note: str


class SearchResult(PlainRecord, frozen=True, kw_only=True):
    """How near a search came to violating a requirement.

    Args:
        suite_margin: the least margin of the suite's own tests.
        margin: the least margin found.
        test: the id of the test that the search started from.
        id: of the test that violates the requirement; `replay` is its file and `abstract` its lines.
    """

    status: Literal["violated", "not violated", "violated by the suite", "never triggered"]
    suite_margin: Number | None
    margin: Number | None
    test: str | None
    runs: Count
    wall_s: NotNegative
    ended: SearchEnd
    id: str | None
    replay: str | None
    abstract: Names
    shrunk: ShrunkTest | None = None
