"""Verdicts on logged runs: those of the reference evaluator, and the same errors as from monitors that are fed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from operator import itemgetter
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings

from pytest_hricdv.monitor import Log, MonitorError, Requirement, Verdict, evaluate, explain
from pytest_hricdv.monitor.formula import Formula
from tests.monitor.logged_run import LoggedRun
from tests.monitor.logs import Logged, log_of, run
from tests.monitor.strategies import formulas, small_traces
from tests.monitor.vocabulary import SMALL, Update, judge, requirement

RUNS = settings(suppress_health_check=[HealthCheck.too_slow])
Series = tuple[Sequence[float], Sequence[float]]
SHOWN = ("x", "y")


@given(formula=formulas, trace=small_traces)
@RUNS
def test_a_run_that_starts_late_is_judged_as_by_monitors_that_are_fed(formula: Formula, trace: LoggedRun) -> None:
    watched, log = [Requirement("R", "", "", "", formula, SHOWN)], log_of(trace, 299.999999999)
    assert evaluate(watched, log) == explain([run(formula, trace, 299.999999999, SHOWN)], watched, log)


def fed(text: str, log: Log) -> Verdict:
    types: dict[str, Callable[[Any], float | bool | str]] = {**SMALL.signals}
    updates: list[Update] = [
        (time_s, name, types[name](value))
        for name, (times, values) in log.signals.items()
        for time_s, value in zip(times, values, strict=True)
    ]
    updates += [(message.time_s, message.topic, dict(message.fields)) for message in log.messages]  # type: ignore[arg-type]
    return judge(text, sorted(updates, key=itemgetter(0)), log.end_s)


P_TRUE: Series = ([0.0], [1.0])
M_LOW = Logged(1.0, "m", {"level": 0.0})


@pytest.mark.parametrize(
    ("text", "signals", "messages", "says"),
    [
        ("always(p -> x < 1)", {"p": ([0.0], [0.0])}, [], "R reads x, which had no value in the whole run"),
        ("always(p -> x < 1)", {"p": P_TRUE, "x": ([1.0], [0.0])}, [], r"R at 0\.0 s reads x, which has no value yet"),
        ("always(p -> x < 1)", {"p": P_TRUE, "x": ([0.0, 0.5], [0.0, math.nan])}, [], r"x at 0\.5 s is nan: not"),
        ("always(p -> x < 1)", {"p": P_TRUE, "x": ([0.0, 0.5], [0.0, math.inf])}, [], r"x at 0\.5 s is inf: not"),
        ("always(p -> x / y < 1)", {"p": P_TRUE, "x": ([0.0], [1.0]), "y": ([0.0], [0.0])}, [], r"R at 0\.0 s: "),
        ("always(rise(x * x > 1) -> p)", {"p": P_TRUE, "x": ([0.0, 0.5], [0.0, 1e300])}, [], r"R at 0\.5 s: "),
        ("always(p -> m.ok)", {"p": P_TRUE}, [], r"R at 0\.0 s reads m\.ok, which has no value yet"),
        ("always(on(a) -> rise(p))", {"p": ([1.0], [1.0])}, [Logged(0.5, "a", {})], r"R at 0\.5 s reads p, which"),
        ("always(m.ok & on(a) -> p)", {"p": P_TRUE}, [Logged(0.5, "a", {})], r"R at 0\.5 s reads m\.ok, which has no"),
        ("always(on(a) -> eventually[0:1](m.ok))", {}, [Logged(0.5, "a", {})], r"R at 0\.5 s reads m\.ok, which has"),
        ("always(on(a) -> always(p) until m.ok)", {"p": P_TRUE}, [Logged(0.5, "a", {})], r"R at 0\.5 s reads m\.ok"),
        ("always(on(a) -> always[0:1](m.ok))", {}, [Logged(0.5, "a", {})], r"R at 0\.5 s reads m\.ok, which has"),
        ("always(on(m) & m.ok -> p)", {"p": P_TRUE}, [Logged(0.5, "m", {})], r"a message 'm' at 0\.5 s has no field"),
        ("always(p -> p)", {"p": ([0.0, 3.0], [1.0, 0.0])}, [], "back in time"),
    ],
)  # fmt: skip
def test_what_the_monitors_refuse_is_refused(
    text: str, signals: dict[str, Series], messages: list[Logged], says: str
) -> None:
    log = Log(signals, messages, 2.0)
    with pytest.raises(MonitorError, match=says):
        evaluate([requirement(text)], log)
    with pytest.raises(MonitorError, match=says):
        fed(text, log)


@pytest.mark.parametrize(
    ("series", "says"),
    [
        (([0.0, 0.5], [1.0, 0.5]), r"p at 0\.5 s is 0\.5: not a bool"),
        (([0.5, 0.0], [1.0, 0.0]), r"back in time: an update at 0\.0 s after one at 0\.5 s"),
        (([math.nan], [1.0]), "a time has to be a finite number of seconds, got nan"),
        (([0.0, math.nan, 1.0], [1.0, 0.0, 1.0]), "a time has to be a finite number of seconds, got nan"),
        (([0.0, math.inf], [1.0, 0.0]), "a time has to be a finite number of seconds, got inf"),
        (([0.0], [1.0, 0.0]), "p: expected one value for each of 1 times, got 2 values"),
        (([0.0], ["yes"]), r"p at 0\.0 s is 'yes': not a bool"),
    ],
)
def test_an_invalid_log_is_refused(series: Series, says: str) -> None:
    with pytest.raises(MonitorError, match=says):
        evaluate([requirement("always(p -> p)")], Log({"p": series}, [], 2.0))


@pytest.mark.parametrize(
    ("text", "signals", "messages", "triggers"),
    [
        ("always(p -> x < 1)", {"p": ([0.0, 2.0], [0.0, 1.0]), "x": ([1.0], [2.0])}, [], [(2.0, 3.0, "failed")]),
        ("always(on(m) & m.level < 1 -> p)", {"p": P_TRUE}, [M_LOW], [(1.0, 1.0, "passed")]),
        (
            "always(p -> y == 0 | x / y > 1)",
            {"p": P_TRUE, "x": ([0.0], [1.0]), "y": ([0.0, 1.0], [0.0, 0.5])},
            [],
            [(0.0, 3.0, "passed")],
        ),
        ("always(p -> x < 1 | m.level < 1)", {"p": P_TRUE, "x": ([0.0], [0.25])}, [], [(0.0, 3.0, "passed")]),
        (
            "always(rise(m.ok) -> p)",
            {"p": P_TRUE},
            [Logged(1.0, "m", {"ok": True}), Logged(2.0, "m", {"ok": False})],
            [],
        ),
        ("always(rise(m.level < 1 [hysteresis 1]) -> p)", {"p": P_TRUE}, [M_LOW], []),
        ("always(on(b) | m.level < 1 -> p)", {"p": P_TRUE}, [M_LOW, Logged(2.0, "b", {})], [(1.0, 3.0, "passed")]),
        (
            "always(on(a) & previously(p) -> p)",
            {"p": ([0.5], [1.0])},
            [Logged(0.5, "a", {}), Logged(1.5, "a", {})],
            [(0.5, 0.5, "passed"), (1.5, 1.5, "passed")],
        ),
    ],
)
def test_a_value_may_be_unknown_where_it_is_not_needed(
    text: str, signals: dict[str, Series], messages: list[Logged], triggers: list[tuple[float, float, str]]
) -> None:
    watched, log = [requirement(text)], Log(signals, messages, 3.0)
    [verdict] = evaluate(watched, log)
    assert [(trigger.begin_s, trigger.end_s, trigger.outcome) for trigger in verdict.history] == triggers
    assert (verdict,) == explain([fed(text, log)], watched, log)
