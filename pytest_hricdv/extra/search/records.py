"""Records of shrunk tests (`ShrunkTest`) and of searches for violations (`SearchResult`) in `report.json`; the options.

`PostSession` makes the records; `SearchView` shows them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from msgspec.structs import replace

from pytest_hricdv._base.record import Count, Names, NotNegative, Number, PlainRecord, ReplayName, TestId
from pytest_hricdv.results.section import FileNames, Section, TestSection

SearchEnd = Literal["done", "runs", "seconds", "interrupted"]
"""Why shrinking or searching ended: nothing left to do, or the budget of runs or seconds was used up, or Ctrl-C."""


class ShrunkTest(PlainRecord, frozen=True, kw_only=True):
    """The shortest test found that fails a requirement for the same reason.

    `id` and `replay` are None where nothing could be removed; `note` says why the test was not shrunk at all. `course`
    says of several actors what each began when, and when the requirement was violated.
    """

    id: TestId | None
    replay: ReplayName | None
    abstract: Names
    concrete: Names
    actions_before: Count
    runs: Count
    wall_s: NotNegative
    end_reason: SearchEnd
    reason: Names
    note: str
    course: Names = ()


class SearchResult(PlainRecord, frozen=True, kw_only=True):
    """How close a search came to violating a requirement.

    Args:
        suite_margin: the least margin of the suite's own tests.
        margin: the least margin found.
        test: the id of the test that the search started from.
        id: the id of the test that violates the requirement; `replay` is its file and `abstract` its lines.
    """

    status: Literal["violated", "not violated", "violated by the suite", "never triggered"]
    suite_margin: Number | None
    margin: Number | None
    test: TestId | None
    runs: Count
    wall_s: NotNegative
    end_reason: SearchEnd
    id: TestId | None
    replay: ReplayName | None
    abstract: Names
    shrunk: ShrunkTest | None = None


def _rename_test(shrunk: ShrunkTest, names: FileNames) -> ShrunkTest:
    return replace(shrunk, replay=names.replay(shrunk.replay))


def _rename_tests(shrunk: Mapping[str, ShrunkTest], names: FileNames) -> Mapping[str, ShrunkTest]:
    return {requirement: _rename_test(test, names) for requirement, test in shrunk.items()}


def _rename_results(results: Mapping[str, SearchResult], names: FileNames) -> Mapping[str, SearchResult]:
    return {
        requirement: replace(
            result,
            replay=names.replay(result.replay),
            shrunk=result.shrunk and _rename_test(result.shrunk, names),
        )
        for requirement, result in results.items()
    }


SEARCH: Section[Mapping[str, SearchResult]] = Section("search", Mapping[str, SearchResult], {}, rename=_rename_results)
"""Requirement -> result, where a search was asked for."""

SHRUNK: TestSection[Mapping[str, ShrunkTest]] = TestSection(
    "shrunk", Mapping[str, ShrunkTest], {}, rename=_rename_tests
)
"""Requirement -> the shortest test found that fails it."""

SECTIONS, TEST_SECTIONS = (SEARCH,), (SHRUNK,)


BUDGET = 60
"""Twice the runs that it takes to drop each of 30 actions once; a test of the table has no more."""


@dataclass(frozen=True)
class SearchOptions:
    """How failing tests are shrunk and violations searched for.

    Args:
        shrink: whether tests are shrunk.
        shrink_runs: most runs for each of them.
        shrink_seconds: time limit (s) for each of them.
        search: most runs for each requirement; 0: there is no search.
    """

    shrink: bool = False
    shrink_runs: int = BUDGET
    shrink_seconds: int = BUDGET
    search: int = 0
