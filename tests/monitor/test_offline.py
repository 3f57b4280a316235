"""Offline evaluation of logged runs: the same verdicts and errors as from the monitors."""

from __future__ import annotations

import math
import subprocess
import sys
from array import array
from collections.abc import Sequence
from operator import itemgetter

import pytest
from hypothesis import HealthCheck, given, settings

from pytest_hricdv.monitor import Log, MonitorError, Requirement, Verdict, explained
from pytest_hricdv.monitor.formula import Formula
from pytest_hricdv.monitor.offline import evaluate
from tests.monitor.logs import Logged, log_of, run
from tests.monitor.reference import Trace
from tests.monitor.strategies import formulas, small_traces, table_traces
from tests.monitor.vocabulary import R1, R2, R3, R4, R5, SMALL, Update, judge, requirement

RUNS = settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.too_slow])
Series = tuple[Sequence[float], Sequence[float]]


def agrees(formula: Formula, trace: Trace, shift_s: float = 0.0, shows: tuple[str, ...] = ()) -> None:
    watched, log = [Requirement("R", "", "", "", formula, shows)], log_of(trace, shift_s)
    assert evaluate(watched, log) == explained([run(formula, trace, shift_s, shows)], watched, log)


@pytest.mark.parametrize("watched", [R1, R2, R3, R4, R5], ids=lambda watched: watched.id)
@given(trace=table_traces)
@RUNS
def test_the_case_study_is_judged_as_by_the_monitors(watched: Requirement, trace: Trace) -> None:
    agrees(watched.formula, trace)


@given(formula=formulas, trace=small_traces)
@settings(RUNS, max_examples=250)
def test_a_random_formula_is_judged_as_by_the_monitors(formula: Formula, trace: Trace) -> None:
    agrees(formula, trace)


@given(formula=formulas, trace=small_traces)
@RUNS
def test_shown_signals_have_the_same_values_as_by_the_monitors(formula: Formula, trace: Trace) -> None:
    agrees(formula, trace, shows=("x", "y"))


@pytest.mark.slow
@given(formula=formulas, trace=small_traces)
@settings(RUNS, max_examples=4000)
def test_a_random_formula_is_judged_as_by_the_monitors_on_thousands_of_runs(formula: Formula, trace: Trace) -> None:
    agrees(formula, trace)


@given(formula=formulas, trace=small_traces)
@RUNS
def test_a_run_that_starts_late_is_judged_as_by_the_monitors(formula: Formula, trace: Trace) -> None:
    agrees(formula, trace, shift_s=299.999999999)


def test_several_requirements_are_judged_in_their_order() -> None:
    signals: dict[str, Series] = {
        "leg_held": (array("d", [0.0]), array("d", [0.0])),
        "leg_torn": ([0.0], [0.0]),
        "hand_closing": ([0.0], [0.0]),
        **{name: ([0.0], [1.0]) for name in ("leg_offset", "hand_distance", "arm_speed")},
    }
    verdicts = evaluate([R4, R1, R2], Log(signals, [], 1.0))
    assert [(verdict.requirement, verdict.verdict) for verdict in verdicts] == [
        ("R4", "Failed"),
        ("R1", "NC"),
        ("R2", "NC"),
    ]
    assert verdicts[0].violations[0].values == {"arm_speed": 1.0}
    assert verdicts[1].nearest_miss is not None


def online(text: str, log: Log) -> Verdict:
    updates: list[Update] = [
        (time_s, name, SMALL.signals[name](value))
        for name, (times, values) in log.signals.items()
        for time_s, value in zip(times, values, strict=True)
    ]
    updates += [(each.time_s, each.topic, dict(each.fields)) for each in log.messages]  # type: ignore[arg-type]
    return judge(text, sorted(updates, key=itemgetter(0)), log.end_s)


P_TRUE: Series = ([0.0], [1.0])


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
        online(text, log)


@pytest.mark.parametrize(
    ("series", "says"),
    [
        (([0.0, 0.5], [1.0, 0.5]), r"p at 0\.5 s is 0\.5: not a bool"),
        (([0.5, 0.0], [1.0, 0.0]), r"back in time: p at 0\.0 s after 0\.5 s"),
        (([math.nan], [1.0]), "the run: a time has to be a finite number of seconds"),
        (([0.0], [1.0, 0.0]), "p: expected 1 numbers, one for each time"),
        (([0.0], ["yes"]), "p: expected 1 numbers"),
    ],
)
def test_an_invalid_log_is_refused(series: Series, says: str) -> None:
    with pytest.raises(MonitorError, match=says):
        evaluate([requirement("always(p -> p)")], Log({"p": series}, [], 2.0))


@pytest.mark.parametrize(
    ("text", "signals", "messages"),
    [
        ("always(p -> x < 1)", {"p": ([0.0, 2.0], [0.0, 1.0]), "x": ([1.0], [2.0])}, []),
        ("always(on(m) & m.level < 1 -> p)", {"p": P_TRUE}, [Logged(1.0, "m", {"level": 0})]),
        ("always(p -> y == 0 | x / y > 1)", {"p": P_TRUE, "x": ([0.0], [1.0]), "y": ([0.0, 1.0], [0.0, 0.5])}, []),
        ("always(p -> x < 1 | m.level < 1)", {"p": P_TRUE, "x": ([0.0], [0.25])}, []),
        ("always(rise(m.ok) -> p)", {"p": P_TRUE}, [Logged(1.0, "m", {"ok": True}), Logged(2.0, "m", {"ok": False})]),
        ("always(rise(m.level < 1 [hysteresis 1]) -> p)", {"p": P_TRUE}, [Logged(1.0, "m", {"level": 0.0})]),
        ("always(on(b) | m.level < 1 -> p)", {"p": P_TRUE}, [Logged(1.0, "m", {"level": 0.0}), Logged(2.0, "b", {})]),
        ("always(on(a) & previously(p) -> p)", {"p": ([0.5], [1.0])}, [Logged(0.5, "a", {}), Logged(1.5, "a", {})]),
    ],
)  # fmt: skip
def test_values_unknown_at_the_start_are_judged_as_by_the_monitors(
    text: str, signals: dict[str, Series], messages: list[Logged]
) -> None:
    log = Log(signals, messages, 3.0)
    watched = [requirement(text)]
    assert evaluate(watched, log) == explained([online(text, log)], watched, log)


def test_numpy_is_imported_only_for_offline_evaluation() -> None:
    script = "import sys, pytest_hricdv.monitor; sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == 0


def test_without_numpy_the_error_names_the_extra() -> None:
    script = "import sys; sys.modules['numpy'] = None; import pytest_hricdv.monitor.offline"
    result = subprocess.run([sys.executable, "-c", script], check=False, capture_output=True, text=True)
    assert "needs numpy: pip install pytest-hricdv[offline]" in result.stderr
