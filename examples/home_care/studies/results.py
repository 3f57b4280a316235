"""What runs of published tests came to: verdicts and coverage, published and here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from studies.published import REQUIREMENTS, VERDICTS, PublishedTest

UNHEARD = "disturb order_lost"
"""The line by which the robot does not hear the next order."""


@dataclass(frozen=True)
class Run:
    """A run here: of which published test, its verdicts of A1 to A4, and its coverage of statements in %.

    `is_unheard`: whether the robot did not hear the first order.
    """

    method: str
    number: int
    verdicts: tuple[str, ...]
    coverage: float
    is_unheard: bool = False


@dataclass(frozen=True)
class Result:
    """The runs of a method's tests: how many of each verdict, for each requirement, and the mean coverage in %."""

    runs: int
    verdicts: tuple[tuple[int, int, int], ...]
    coverage: float

    def share(self, requirement: int, verdict: int) -> float:
        """In %."""
        return 100.0 * self.verdicts[requirement][verdict] / self.runs if self.runs else 0.0


def runs_of(report: Mapping[str, list[dict[str, object]]]) -> list[Run]:
    """The runs of published tests in a report."""
    runs = []
    for test in report["tests"]:
        _, method, number = str(test["name"]).split()
        held, code = test["requirements"], test["code"]
        assert isinstance(held, dict)
        assert isinstance(code, dict)
        verdicts = tuple(held[name]["verdict"] for name in REQUIREMENTS)
        lines = test["abstract"]
        assert isinstance(lines, list)
        runs.append(Run(method, int(number), verdicts, float(code["percent"]), lines[:1] == [UNHEARD]))
    return runs


def result(runs: Sequence[Run]) -> Result:
    """The result of runs."""
    verdicts = tuple(
        (
            sum(run.verdicts[place] == VERDICTS[0] for run in runs),
            sum(run.verdicts[place] == VERDICTS[1] for run in runs),
            sum(run.verdicts[place] == VERDICTS[2] for run in runs),
        )
        for place in range(len(REQUIREMENTS))
    )
    return Result(len(runs), verdicts, sum(run.coverage for run in runs) / len(runs) if runs else 0.0)


def published_result(tests: Sequence[PublishedTest]) -> Result:
    """The published result of tests: of the runs that started."""
    counts = [test.counts for test in tests if test.counts is not None]
    runs = sum(count.started for count in counts)
    verdicts = tuple(
        (
            sum(count.verdicts[place][0] for count in counts),
            sum(count.verdicts[place][1] for count in counts),
            sum(count.verdicts[place][2] for count in counts),
        )
        for place in range(len(REQUIREMENTS))
    )
    return Result(runs, verdicts, sum(count.coverage_sum for count in counts) / runs if runs else 0.0)


def agreement(tests: Sequence[PublishedTest], runs: Sequence[Run], requirement: int) -> tuple[float, float]:
    """In how many % of its published runs a test's verdict is the most frequent one here, and the one there.

    The second figure is the greatest that the first can be.
    """
    here = there = started = 0
    for test in tests:
        own = [run.verdicts[requirement] for run in runs if (run.method, run.number) == (test.method, test.number)]
        if test.counts is None or not own:
            continue
        row = test.counts.verdicts[requirement]
        most = max(VERDICTS, key=own.count)
        here, there, started = here + row[VERDICTS.index(most)], there + max(row), started + test.counts.started
    return (100.0 * here / started, 100.0 * there / started) if started else (0.0, 0.0)
