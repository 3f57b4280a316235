"""The line that a session adds to its history."""

from __future__ import annotations

from collections import Counter

from pytest_hricdv.extra.trend.records import MOST_NAMED, HistoryEntry, HistoryVerdicts
from pytest_hricdv.results.derivation import code_covered
from pytest_hricdv.results.model import Report
from pytest_hricdv.results.section import failure_causes


def entry_of(report: Report, *, is_whole: bool) -> HistoryEntry:
    """What a history keeps of a report, which has an origin.

    Args:
        is_whole: all tests of its suites ran.
    """
    origin, suites = report.origin, report.suites
    assert origin is not None
    outcomes = Counter(test.outcome for test in report.tests)
    plans = [agent for suite in suites[:1] for agent in suite.plans.values()]
    cross = suites[0].cross if suites else None
    return HistoryEntry(
        began=origin.began,
        revision=origin.revision,
        dirty=origin.dirty,
        compared_by=" ".join(
            [report.testbench, *(f"{suite.name}:{suite.seed}" for suite in suites), *report.rerun.options, report.shard]
        ),
        whole=is_whole,
        tests=report.reported,
        outcomes=dict(sorted(outcomes.items())),
        causes=failure_causes(report),
        failing=tuple(sorted(test.id for test in report.tests if test.fails))[:MOST_NAMED],
        requirements={name: _verdicts(report, name) for name in report.requirements},
        statements=_percent(*code_covered(report, "statements")),
        branches=_percent(*code_covered(report, "branches")),
        plans=_percent(sum(len(agent.covered) for agent in plans), sum(agent.total for agent in plans)),
        cross=_percent(cross.hit, cross.possible) if cross is not None else None,
        sim_s=round(sum(test.sim_s for test in report.tests), 3),
        wall_s=report.wall_s,
    )


def _verdicts(report: Report, name: str) -> HistoryVerdicts:
    tallies = [suite.requirements[name] for suite in report.suites if name in suite.requirements]
    return HistoryVerdicts(
        passed=sum(tally.passed for tally in tallies),
        failed=sum(tally.failed for tally in tallies),
        nc=sum(tally.nc for tally in tallies),
        triggers=sum(tally.triggers for tally in tallies),
    )


def _percent(part: int, whole: int) -> float | None:
    return round(100.0 * part / whole, 2) if whole else None
