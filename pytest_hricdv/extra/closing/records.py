"""Records of a closing loop in `report.json`: points that are hit, points that cannot be, and evidence on open ones.

`evidence` makes the `ClosingResult` of a loop, which has all other records, and `view` shows it. `CLOSING` is its
section of the report. `ClosingOptions` are the options that `ClosingFeature` reads.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

from msgspec import Meta, Struct

from pytest_hricdv._base.record import Count, Names, NotNegative, Number, PlainRecord
from pytest_hricdv.results.section import Section

ClosingEnd = Literal["closed", "runs", "seconds", "nothing to try", "interrupted", "error"]
"""Why a loop ended: nothing is open, no runs or seconds are left, no strategy knows a test, Ctrl-C, or an error of the
loop itself, which the notes of the suite describe."""

RULE_OF_THREE = 3.0
"""-ln(0.05), rounded up: if n runs had no success, the probability of one is below 3/n (95 % confidence; see
`evidence`)."""

Probability = Annotated[int, Meta(ge=0, le=1)] | Annotated[float, Meta(ge=0, le=1)]


class HitPoint(PlainRecord, frozen=True, kw_only=True):
    """A point that is hit.

    Args:
        point: its kind and its names.
        test: the id of a test that hits it: of the suite, or of one that was there before the loop.
        strategy: the strategy that led to the first run that hit it.
        run: the number of this run, from 1; 0 of tests that were there before the loop.
    """

    point: Names
    test: str
    strategy: str
    run: Count


class ImpossiblePoint(PlainRecord, frozen=True, kw_only=True):
    """A point that cannot be hit: by declaration, by a waiver in the code, or because the model cannot."""

    point: Names
    reason: str
    by: Literal["declared", "waived", "model"]


class OpenPoint(PlainRecord, frozen=True, kw_only=True):
    """A point that no run hit.

    Args:
        tries: runs that were aimed at it.
        bound: upper bound of the probability that such a run hits it; None if no run was aimed at it.
        test: the id of the test that came nearest; empty where nothing is known.
        lacking: what this test missed, or what else is known.
        waiver: a line that declares the point impossible; empty if there is none.
    """

    point: Names
    tries: Count
    bound: Probability | None = None
    test: str = ""
    lacking: str = ""
    waiver: str = ""


class ViolationKind(PlainRecord, frozen=True, kw_only=True):
    """Violations that are alike: of the same part of a requirement, in the same state, and with the same outcome.

    Args:
        requirement: empty for what was wrong with a run other than its requirements, which `part` then says.
        part: the conditions that were false.
        state: the state of the code under test; empty if it names none.
        outcome: how the interaction ended in which it happened; empty if there was none, or where it did not end.
        known: whether such violations are known.
        runs: number of runs with a violation of the kind.
        test: the id of a test that has one: of the suite, or of one that was there before the loop.
    """

    requirement: str
    part: str
    state: str = ""
    outcome: str = ""
    known: bool = False
    runs: Count
    test: str


class KindCount(PlainRecord, frozen=True, kw_only=True):
    """The numbers of hit, impossible and open points of a kind."""

    hit: Count
    impossible: Count
    open: Count


class StrategyResult(PlainRecord, frozen=True, kw_only=True):
    """The results of a strategy: its runs, their simulated time (s), and kind -> new points."""

    runs: Count
    sim_s: NotNegative
    new: Mapping[str, Count]


class GrowthStep(PlainRecord, frozen=True, kw_only=True):
    """A run that hit new points.

    Args:
        run: its number, from 1; 0 of tests that were there before the loop.
        sim_s: simulated time of the loop, this run included (s).
        strategy: the strategy that proposed it.
        new: kind -> how many points no earlier run had hit.
    """

    run: Count
    sim_s: NotNegative
    strategy: str
    new: Mapping[str, Count]


class NearestRun(PlainRecord, frozen=True, kw_only=True):
    """The run that came closest to violating a requirement.

    Args:
        margin: the least one of all runs, in its unit; None where nothing was compared.
        spread: by how much the least margins of runs differ, in the same unit.
        test: the id of the test that had the least margin; empty if none had one.
        runs: number of runs that triggered it.
        searched: runs that were made to violate it.
        vacuous_alternatives: the alternatives of its response by which it never held.
    """

    requirement: str
    margin: Number | None
    spread: NotNegative | None
    test: str
    runs: Count
    searched: Count
    vacuous_alternatives: Names = ()


class ViolationEstimate(PlainRecord, frozen=True, kw_only=True):
    """The expected number of new kinds of violations in another run, after Good (1953): The population frequencies of
    species, Biometrika 40.

    Args:
        kinds: number of kinds of violations that are not known, in all runs.
        once: number of these that occurred in exactly one run.
        runs: number of runs that came to their end.
        new: once / runs: how many further kinds a further run is expected to show.
    """

    kinds: Count
    once: Count
    runs: Count
    new: NotNegative


class ClosingResult(PlainRecord, frozen=True, kw_only=True):
    """The result of a closing loop. Bounds and estimates are as if runs were independent.

    Args:
        suite: the name of the suite that it led to.
        budget: largest number of runs.
        runs: number of runs that were made; `errored_runs` of them did not end.
        initial_runs: tests that were there before the loop; they are not part of `runs` and `sim_s`.
        sim_s: simulated time of its runs (s).
        bound: upper bound of the probability that a run hits a certain open point; None without runs.
        kinds: kind of points -> how many.
        strategies: what each strategy has brought.
        growth: the runs that hit new points, in order.
        violations: the kinds of violations in runs, unknown ones first.
        searched: runs that searched for violations.
        closest_runs: for each requirement that a run triggered, how close runs came to violating it.
        estimated_undetected: how many further kinds of violations there probably are; None without runs.
        closest_tests: tests that came nearest to an open point, or to a violation, and are in no suite: id -> text, as
            `--hri-suite=FILE` reads it.
    """

    suite: str
    end_reason: ClosingEnd
    budget: Count
    runs: Count
    initial_runs: Count
    errored_runs: Count
    sim_s: NotNegative
    bound: Probability | None
    kinds: Mapping[str, KindCount]
    strategies: Mapping[str, StrategyResult]
    growth: tuple[GrowthStep, ...]
    hit: tuple[HitPoint, ...]
    impossible: tuple[ImpossiblePoint, ...]
    open: tuple[OpenPoint, ...]
    violations: tuple[ViolationKind, ...] = ()
    searched: Count = 0
    closest_runs: tuple[NearestRun, ...] = ()
    estimated_undetected: ViolationEstimate | None = None
    closest_tests: Mapping[str, str] = {}


CLOSING: Section[ClosingResult | None] = Section("closing", ClosingResult | None, None)
"""The closing loop that generated a suite; a merged report has it if all sessions had the same."""

SECTIONS = (CLOSING,)


def target_suite(report: Struct) -> str:
    """The suite that the loop generated to reach all there is; empty if there is none."""
    result = CLOSING.of(report)
    return result.suite if result is not None else ""


@dataclass(frozen=True)
class ClosingOptions:
    """Whether there is a closing loop, and its budget.

    Args:
        asked: whether the loop runs.
        given: whether the loop closes only what other suites leave open.
        runs: largest number of runs. See docs/studies/closure.md for how many a loop takes.
        search: runs that search for violations after it, if as many are left; None: a tenth of the runs that the
            loop made, and at least a generation. A loop that closes costs little more, and a fault that one run
            in twenty shows near to what is known is met with five times out of six in thirty.
        seconds: it ends after this time (s), so that a session is not endless: its result then depends on the machine.
            The same loops took up to 3.1 minutes on two cores; three times this.
        without: the names of strategies that are left out.
    """

    asked: bool = False
    given: bool = False
    runs: int = 400
    search: int | None = None
    seconds: int = 600
    without: tuple[str, ...] = ()
