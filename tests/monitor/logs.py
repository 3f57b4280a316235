"""Random runs: as logs, judged by the monitors, and what of a verdict is compared with the reference evaluator."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pytest_hricdv.monitor import MonitorSet, Requirement, Verdict
from pytest_hricdv.monitor.formula import Formula
from pytest_hricdv.monitor.log import Log
from tests.monitor.logged_run import TICK_S, LoggedRun, Value
from tests.monitor.reference import Summary, in_order


@dataclass(frozen=True)
class Logged:
    """A message of a log."""

    time_s: float
    topic: str
    fields: Mapping[str, Value]


def log_of(trace: LoggedRun, shift_s: float = 0.0) -> Log:
    """The trace as it would have been recorded."""
    signals: dict[str, tuple[list[float], list[Any]]] = {}
    messages = []
    for tick, instant in sorted(trace.instants.items()):
        time_s = tick * TICK_S + shift_s
        for name, value in instant.signals.items():
            times, values = signals.setdefault(name, ([], []))
            times.append(time_s)
            values.append(value if isinstance(value, str) else float(value))
        messages += [Logged(time_s, topic, fields) for topic, fields in instant.messages]
    return Log(signals, messages, trace.last * TICK_S + shift_s)


def run(formula: Formula, trace: LoggedRun, shift_s: float = 0.0, shows: tuple[str, ...] = ()) -> Verdict:
    """The verdict of a monitor that is fed the trace."""
    monitors = MonitorSet([Requirement("R", "", "", "", formula, shows)])
    [verdict] = feed_trace(monitors, trace, shift_s)
    return verdict


def feed_trace(monitors: MonitorSet, trace: LoggedRun, shift_s: float = 0.0) -> tuple[Verdict, ...]:
    """The verdicts of monitors that are fed the whole trace."""
    for tick, instant in sorted(trace.instants.items()):
        time_s = tick * TICK_S + shift_s
        for name, value in instant.signals.items():
            monitors.signal(time_s, name, value)
        for topic, fields in instant.messages:
            monitors.message(time_s, topic, fields)
    return monitors.finish(trace.last * TICK_S + shift_s)


def summary(verdict: Verdict) -> Summary:
    """What the reference evaluator has to agree with; the rest of the verdict has to be consistent with it."""
    assert verdict.triggers == verdict.passes + verdict.failures + verdict.pending
    assert verdict.untriggered == (verdict.triggers == 0)
    outcomes: list[str] = [trigger.outcome for trigger in verdict.history]
    counted = {"passed": verdict.passes, "failed": verdict.failures, "pending": verdict.pending}
    assert {outcome: outcomes.count(outcome) for outcome in counted} == counted
    assert all(trigger.begin_s <= trigger.end_s for trigger in verdict.history)
    times = [violation.time_s for violation in verdict.violations]
    assert times == sorted(times)
    return Summary(
        verdict.verdict,
        verdict.triggers,
        verdict.passes,
        verdict.failures,
        verdict.pending,
        sorted(verdict.violations, key=in_order),
        verdict.margin,
        verdict.margin_time_s,
    )
