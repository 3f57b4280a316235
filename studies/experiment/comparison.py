"""Figures of a report beside the published ones: plain data for the page's template."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean
from typing import Any

from pytest_hricdv.results.proportion import Interval
from studies.estimates import mean
from studies.original.published import METHODS, RUN_S, Published
from studies.original.requests import MAX_TURNS, leg_requests
from studies.original.runs import OriginalRun, load_runs, method_of

Entry = Mapping[str, Any]
READ = ("released", "discarded")
"""How a turn ends in which the sensors were read."""


@dataclass(frozen=True)
class RequestStatistics:
    """What a method's tests ask for, and the results.

    Args:
        tests: how many.
        no_request: tests that never ask for a leg.
        all_ready: ask for a leg with gaze, pressure and location all ready.
        all_ready_checked: of those, how many checked R1.
        not_ready: let the robot read its sensors when not all of them are ready.
        not_ready_checked: of those, how many checked R2.
        turns: all together; None where that is not known of all.
        begun: tests with a turn; likewise.
        failed: tests that failed R3.
        releasing: coverage (%) of the tests in which a leg was released.
        others: of the others.
    """

    tests: int
    no_request: int
    all_ready: int
    all_ready_checked: int
    not_ready: int
    not_ready_checked: int
    turns: int | None
    begun: int | None
    failed: int
    releasing: float | None
    others: float | None


@dataclass(frozen=True)
class Method:
    """One method's figures.

    Args:
        suite: of the report.
        published: what the paper says.
        verdicts: requirement -> passed, failed, not checked.
        percents: of each test's statements, ascending.
        mean: of them.
        ours: what the tests ask for.
        original: the same for the original's recorded tests.
        busy_s: worker seconds of its runs.
    """

    suite: Entry
    published: Published
    verdicts: Mapping[str, tuple[int, int, int]]
    percents: tuple[float, ...]
    mean: Interval
    ours: RequestStatistics
    original: RequestStatistics
    busy_s: float

    @property
    def name(self) -> str:
        """Of the suite."""
        return str(self.suite["name"])

    @property
    def most(self) -> float:
        """The highest coverage of a test (%)."""
        return self.percents[-1]

    @property
    def running_s(self) -> tuple[float, float]:
        """What so many runs took originally, least and most (s)."""
        return self.published.tests * RUN_S[0], self.published.tests * RUN_S[1]


def methods(report: Entry) -> dict[str, Method]:
    """The figures of each method by name. A test that did not come to its end has no part in them.

    Raises:
        KeyError: the report lacks one of the four suites.
    """
    suites = {suite["name"]: suite for suite in report["suites"]}
    runs = load_runs()
    return {name: _method(suites[name], report, published, runs) for name, published in METHODS.items()}


def _method(suite: Entry, report: Entry, published: Published, runs: Sequence[OriginalRun]) -> Method:
    tests = [test for test in report["tests"] if test["suite"] == suite["name"] and test["code"] is not None]
    percents = tuple(sorted(float(test["code"]["percent"]) for test in tests))
    return Method(
        suite=suite,
        published=published,
        verdicts={name: (r["passed"], r["failed"], r["nc"]) for name, r in suite["requirements"].items()},
        percents=percents,
        mean=mean(percents),
        ours=_request_statistics(
            [(t["abstract"], _verdicts(t), tuple(t["outcomes"]), float(t["code"]["percent"])) for t in tests]
        ),
        original=_request_statistics(
            [(r.lines, r.verdicts, r.legs, r.coverage) for r in runs if method_of(r.suite) == suite["name"]]
        ),
        busy_s=sum(test["wall_s"] for test in tests),
    )


def _verdicts(test: Entry) -> dict[str, str]:
    return {name: judged["verdict"] for name, judged in test["requirements"].items()}


Row = tuple[Sequence[str], Mapping[str, str], tuple[str, ...] | None, float]


def _request_statistics(rows: Sequence[Row]) -> RequestStatistics:
    requests = [leg_requests(lines)[:MAX_TURNS] for lines, *_ in rows]
    verdicts = [judged for _, judged, *_ in rows]
    all_ready = [any(turn.all_ready for turn in turns) for turns in requests]
    not_ready = [any(turn.answered and not turn.all_ready for turn in turns) for turns in requests]
    legs = [outcomes for _, _, outcomes, _ in rows if outcomes is not None]
    complete = len(legs) == len(rows)
    releasing = [cover for *_, outcomes, cover in rows if "released" in (outcomes or ())]
    others = [cover for *_, outcomes, cover in rows if "released" not in (outcomes or ())]
    return RequestStatistics(
        tests=len(rows),
        no_request=sum(not turns for turns in requests),
        all_ready=sum(all_ready),
        all_ready_checked=sum(
            wanted and judged["R1"] != "NC" for wanted, judged in zip(all_ready, verdicts, strict=True)
        ),
        not_ready=sum(not_ready),
        not_ready_checked=sum(
            wanted and judged["R2"] != "NC" for wanted, judged in zip(not_ready, verdicts, strict=True)
        ),
        turns=sum(map(len, legs)) if complete else None,
        begun=sum(map(bool, legs)) if complete else None,
        failed=sum(judged["R3"] == "Failed" for judged in verdicts),
        releasing=fmean(releasing) if complete and releasing else None,
        others=fmean(others) if complete and others else None,
    )
