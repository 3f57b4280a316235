"""Coverage as a report holds it: the records of code, plans, requirements and gaps.

`results.derivation` makes them, reports show them. They are msgspec structs: frozen like frozen dataclasses, but also
their own JSON codec. See `pytest_hricdv.results.model` for the rules that all records follow.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from msgspec import Meta

from pytest_hricdv._base.record import Count, Names, NotNegative, Percent, PlainRecord

Bits = Annotated[str, Meta(pattern=r"^0x(0|[1-9a-f][0-9a-f]*)\Z")]
"""A set of bits as a hexadecimal number."""
ArcRecord = tuple[int, int]
"""From line, to line; a negative line is the exit of a function."""


# Code


class WaiverRecord(PlainRecord, frozen=True, kw_only=True):
    """A statement that its author declared unreachable, and why."""

    file: str
    line: Count
    reason: str


class MappedFile(PlainRecord, frozen=True, kw_only=True):
    """A file of the code under test. Bits of tests number all files' statements in this order; branches likewise."""

    file: str
    statements: tuple[Count, ...]
    branches: tuple[ArcRecord, ...]
    source: str


class FileCoverage(PlainRecord, frozen=True, kw_only=True):
    """The coverage of a file by all tests together."""

    file: str
    statements: Count
    covered: Count
    missing_lines: tuple[Count, ...]
    missing_branches: tuple[ArcRecord, ...]


class ReportedCode(PlainRecord, frozen=True, kw_only=True):
    """The code under test: what there is to cover, and what all tests covered.

    `reason` says why it was not measured, or not completely; empty if it was. `never_imported` are files that no
    test imported, so that nothing of them was run. `unmeasured_files` are others of which not all was measured, each
    with the reason.
    """

    packages: Names
    sha256: str
    waivers: tuple[WaiverRecord, ...]
    map: tuple[MappedFile, ...]
    measured: bool
    reason: str
    files: tuple[FileCoverage, ...]
    never_imported: Names = ()
    unmeasured_files: Mapping[str, str] = {}


class CodeShare(PlainRecord, frozen=True, kw_only=True):
    """The code coverage of one test; `bits` are statements and branches as hexadecimal numbers.

    Branches are None if only lines were measured. `unmeasured` are files of which not all was measured, with the
    reasons.
    """

    statements: Count
    percent: Percent
    bits: tuple[Bits, Bits | None]
    unmeasured: Mapping[str, str] = {}


class CodeCoverage(PlainRecord, frozen=True, kw_only=True):
    """Covered statements (or branches) of a suite. `reachable` is the total less the waived ones."""

    covered: Count
    total: Count
    reachable: Count
    percent: Percent
    percent_reachable: Percent


class SuiteCode(PlainRecord, frozen=True, kw_only=True):
    """Code coverage of a suite; None if it was not measured."""

    statements: CodeCoverage | None
    branches: CodeCoverage | None


# Plans


class PlanReach(PlainRecord, frozen=True, kw_only=True):
    """How a plan is reached: by how many tests and belief sets, the smallest of these, and a test that has it."""

    tests: Count
    belief_sets: Count
    shortest: Names
    test: str


class PlanCoverage(PlainRecord, frozen=True, kw_only=True):
    """The plans of one agent. `declared` are all, in source order; `reached` leaves out plans without a test."""

    covered: Names
    missing: Names
    total: Count
    declared: Names
    reached: Mapping[str, PlanReach]


# Requirements


class RequirementTally(PlainRecord, frozen=True, kw_only=True):
    """One requirement over the tests of a suite.

    `passed`, `failed`, `nc` count tests by verdict; a test that was not run has none. `triggers` counts how often the
    antecedent was triggered: `passes`, `failures` and `pending` ones. `untriggered` counts runs in which the antecedent
    never held. `outside` counts the failed tests with a violation outside of the condition under which violations of
    the requirement are known. `vacuous_alternatives` are the alternatives of its response by which it held
    in no test, if one triggered it. `masked_messages` counts, by topic, the messages that were not evaluated because
    another one of the topic came at the same instant.
    """

    passed: Count
    failed: Count
    nc: Count
    triggers: Count
    passes: Count
    failures: Count
    untriggered: Count
    pending: Count
    outside: Count = 0
    vacuous_alternatives: Names = ()
    masked_messages: Mapping[str, Count] = {}


# Over all kinds of coverage


class CurvePoint(PlainRecord, frozen=True, kw_only=True):
    """Coverage after a number of tests."""

    tests: Count
    statements: Count
    branches: Count
    plans: Count


class MinimalStep(PlainRecord, frozen=True, kw_only=True):
    """A test of the minimal suite: points new with it; points and simulated time up to it."""

    nodeid: str
    id: str
    gain: Count
    points: Count
    sim_s: NotNegative


GapKind = Literal["statements", "branches", "plans", "bins", "requirements"]


class Gap(PlainRecord, frozen=True):
    """Something that no test covers.

    Args:
        kind: what is missing.
        location: where: a file and function, an agent, a cross product, a requirement.
        items: what: lines, branches as `30->31`, a plan, a bin.
        reason: why it is not covered, as far as that is known.
        suggestion: what is likely to cover it; empty where nothing is known.
        test: the id of the test that came nearest; may be empty.
        beliefs: the belief set that is likely to cover it; may be empty.
    """

    kind: GapKind
    location: str
    items: Names
    reason: str
    suggestion: str
    test: str
    beliefs: Names


class Closure(PlainRecord, frozen=True, kw_only=True):
    """The joint coverage of tests, of all kinds, and a minimal set of tests that suffices for it.

    A point is a statement, a branch, a plan, a bin, or a verdict (Passed, Failed) of a requirement.

    Args:
        points: covered by all tests.
        sim_s: simulated time of all tests.
        growth: simulated time and points so far, at each test that adds a point, in the order of the tests.
        minimal: tests that suffice for all points, those first that add most per simulated second.
        adds_nothing: node ids of the other tests.
        unique: node id -> points that no other test covers; tests without one are left out.
        gaps: the gaps of the whole report; None for a suite.
    """

    points: Count
    sim_s: NotNegative
    growth: tuple[tuple[NotNegative, Count], ...]
    minimal: tuple[MinimalStep, ...]
    adds_nothing: Names
    unique: Mapping[str, Count]
    gaps: tuple[Gap, ...] | None = None
