"""The first difference of two runs: what it is called, and which runs count as changed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from pytest_hricdv.results.baseline import baseline_of, read_baseline, write_baseline
from pytest_hricdv.results.behaviour import Behaviour, BusMessage
from pytest_hricdv.results.behaviour_diff import change_of, compare_behaviour, headline
from pytest_hricdv.results.model import Report, TestResult, Timeline
from tests.results import reports

REQUEST = BusMessage(1.5, "human", "request", {})
READY = BusMessage(21.25, "robot", "leg_ready", {"turn": 1})
DONE = BusMessage(31.2, "robot", "turn_done", {"turn": 1, "outcome": "released"})
RUN = (REQUEST, READY, DONE)


def behaviour(*messages: BusMessage, **changes: Any) -> Behaviour:
    fields: dict[str, Any] = {
        "record_sha256": repr(messages),
        "parameters": "00000000",
        "end_reason": "table done",
        "end_s": 40.0,
        "outcomes": ("released",),
        "messages": messages,
        "signals": {"speed": "0a", "touch": "0b"},
        "verdicts": {"R1": ("Passed", 0.25)},
    }
    return Behaviour(**(fields | changes))


def with_fields(message: BusMessage, **fields: Any) -> BusMessage:
    return message._replace(fields={**message.fields, **fields})


@pytest.mark.parametrize(
    ("now", "kind", "text"),
    [
        (
            (REQUEST, READY, with_fields(DONE, outcome="discarded")),
            "`turn_done(discarded)` instead of `turn_done(released)`",
            "at 31.2 s `turn_done(discarded)` instead of `turn_done(released)`",
        ),
        (
            (REQUEST, READY, with_fields(DONE, outcome="discarded")._replace(time_s=29.04)),
            "`turn_done(discarded)` instead of `turn_done(released)`",
            "at 29.0 s `turn_done(discarded)` instead of `turn_done(released)` at 31.2 s",
        ),
        (
            (REQUEST, with_fields(READY, turn=2), DONE),
            "`leg_ready` with another `turn`",
            "at 21.2 s `leg_ready(turn=2)` instead of `leg_ready(turn=1)`",
        ),
        (
            (REQUEST, READY, with_fields(DONE, turn=0, outcome="discarded")),
            "`turn_done(discarded)` instead of `turn_done(released)`",
            "at 31.2 s `turn_done(turn=0, outcome=discarded)` instead of `turn_done(turn=1, outcome=released)`",
        ),
        (
            (REQUEST, BusMessage(20.0, "robot", "gave_up", {}), DONE),
            "`gave_up` instead of `leg_ready`",
            "at 20.0 s `gave_up` instead of `leg_ready(turn=1)` at 21.2 s",
        ),
        ((REQUEST, DONE), "`leg_ready` is missing", "at 21.2 s `leg_ready(turn=1)` is missing"),
        (
            (REQUEST, READY),
            "`turn_done(released)` is missing",
            "at 31.2 s `turn_done(turn=1, outcome=released)` is missing",
        ),
        (
            (REQUEST, BusMessage(2.0, "robot", "hello", {"loud": True}), READY, DONE),
            "`hello(loud=true)` is extra",
            "at 2.0 s `hello(loud=true)` is extra",
        ),
        (
            (*RUN, BusMessage(35.0, "robot", "table_done", {"duration_s": 1 / 3})),
            "`table_done` is extra",
            "at 35.0 s `table_done(duration_s=0.333333)` is extra",
        ),
        (
            (REQUEST, READY._replace(time_s=22.75), DONE),
            "`leg_ready` later",
            "at 22.8 s `leg_ready(turn=1)`, 1.5 s later than before",
        ),
        (
            (REQUEST, READY, DONE._replace(time_s=31.196)),
            "`turn_done(released)` earlier",
            "at 31.2 s `turn_done(turn=1, outcome=released)`, 0.004 s earlier than before",
        ),
        (
            (REQUEST, DONE._replace(time_s=20.0), READY),
            "`turn_done(released)` earlier",
            "at 20.0 s `turn_done(turn=1, outcome=released)`, 11.2 s earlier than before",
        ),
        (
            (REQUEST, DONE, READY._replace(time_s=33.25)),
            "`leg_ready` later",
            "at 33.2 s `leg_ready(turn=1)`, 12.0 s later than before",
        ),
        (
            (REQUEST, DONE._replace(time_s=READY.time_s), READY),
            "`turn_done(released)` instead of `leg_ready`",
            "at 21.2 s `turn_done(turn=1, outcome=released)` instead of `leg_ready(turn=1)`",
        ),
        (
            (REQUEST, READY, DONE._replace(sender="ghost")),
            "`turn_done(released)` from another sender",
            "at 31.2 s `turn_done(turn=1, outcome=released)` instead of `turn_done(turn=1, outcome=released)`",
        ),
    ],
)
def test_the_first_message_that_differs_is_named(now: tuple[BusMessage, ...], kind: str, text: str) -> None:
    change = change_of(behaviour(*RUN), behaviour(*now))
    assert change is not None
    assert (change.kind, change.text) == (kind, text)
    assert change.time_s is not None
    assert change.topic in kind


@pytest.mark.parametrize(
    ("now", "kind", "text"),
    [
        (
            {"record_sha256": "other", "signals": {"speed": "0c", "touch": "0b"}},
            "only signals differ",
            "the messages are the same, but signal speed differs",
        ),
        (
            {"record_sha256": "other", "signals": {"speed": "0c", "home": "00", "height": "00"}},
            "only signals differ",
            "but signal speed differs; signals height, home are new; signal touch is missing",
        ),
        ({"record_sha256": "other"}, "messages less than 1 ms earlier or later", "less than 1 ms"),
        (
            {"end_reason": "limit"},
            "ended with 'limit' instead of 'table done'",
            "the messages are the same, but it ended",
        ),
        ({"outcomes": ()}, "other outcomes", "the messages are the same, but it had the outcomes none instead of rel"),
        ({"errors": ("node a at 3 s: it broke",)}, "other faults", "had the faults node a at 3 s: it broke instead of"),
        ({"record_sha256": None}, "ends in error", "the test is in error; before, its run came to its end"),
        (
            {"record_sha256": "other", "parameters": "ff"},
            "has other parameters",
            "the test itself has other parameters; messages come less than 1 ms earlier or later",
        ),
    ],
)
def test_what_differs_beside_the_messages_is_named(now: dict[str, Any], kind: str, text: str) -> None:
    change = change_of(behaviour(*RUN), behaviour(*RUN, **now))
    assert change is not None
    assert change.kind == kind
    assert text in change.text
    assert change.time_s is None


def test_runs_with_the_same_record_and_end_are_no_change() -> None:
    other_verdict = behaviour(*RUN, verdicts={"R1": ("Failed", -1.0)})  # by another requirement, not by the run
    assert change_of(behaviour(*RUN), other_verdict) is None


def test_what_follows_from_the_first_difference_is_listed() -> None:
    now = behaviour(
        REQUEST,
        end_reason="limit",
        outcomes=("released", "none"),
        verdicts={"R1": ("Failed", -0.5), "R2": ("Passed", 0.125), "R3": ("NC", None)},
    )
    before = behaviour(*RUN, verdicts={"R1": ("Passed", 0.25), "R2": ("Passed", 0.25)})
    change = change_of(before, now)
    assert change is not None
    assert change.also == (
        "ended with 'limit' instead of 'table done'",
        "had the outcomes released, none instead of released",
        "R1 Failed instead of Passed",
        "margin of R2 0.125 instead of 0.25",
    )


topics = st.sampled_from(["a", "b", "c"])
times = st.lists(st.sampled_from([0.5, 1.0, 1.5, 2.0]), max_size=5).map(sorted)
runs = st.builds(
    lambda at, said: tuple(BusMessage(t, "robot", topic, {}) for t, topic in zip(at, said, strict=False)),
    times,
    st.lists(topics, min_size=5, max_size=5),
)


@given(runs, runs)
def test_a_difference_is_found_exactly_where_runs_differ_and_never_after_it(
    before: tuple[BusMessage, ...], now: tuple[BusMessage, ...]
) -> None:
    change = change_of(behaviour(*before), behaviour(*now))
    assert (change is None) == (before == now)
    if change is not None:
        same = next((n for n, (old, new) in enumerate(zip(before, now, strict=False)) if old != new), None)
        at = min(len(before), len(now)) if same is None else same
        assert change.time_s in {run[at].time_s for run in (before, now) if at < len(run)}


# Whole reports


def ran(number: int, *messages: BusMessage, **changes: Any) -> TestResult:
    lines = ["\t".join([str(m.time_s), m.sender, m.topic, json.dumps(m.fields)]) for m in messages]
    made = Timeline(end_s=40.0, messages=tuple(lines), signals={}, triggers={}, checksums={"speed": "0a"})
    fields = {"outcome": "passed", "record_sha256": repr(messages), "timeline": made, "end_reason": "done"}
    return reports.result(number, **(fields | changes))


def kept(report: Report, folder: Path) -> Path:
    path = folder / "base.json"
    write_baseline(baseline_of(report), path)
    return path


def test_a_file_keeps_the_behaviour_with_a_line_for_each_test(tmp_path: Path) -> None:
    report = reports.report([ran(1, *RUN), ran(2, REQUEST), reports.result(3, outcome="error")])
    path = kept(report, tmp_path)
    assert read_baseline(path, "toy") == baseline_of(report)
    (line,) = [line for line in path.read_text(encoding="utf-8").splitlines() if line.startswith('    "rl-leg1":')]
    assert '[31.2,"robot","turn_done",{"outcome":"released","turn":1}]' in line
    changes = compare_behaviour(report, read_baseline(path, "toy"), whole=True)
    assert (changes.compared, changes.changed, changes.new, changes.removed) == (3, {}, (), ())
    assert headline(changes) == "all 3 tests behave as in the baseline"


def test_changes_are_counted_by_kind_and_the_earliest_is_the_example(tmp_path: Path) -> None:
    late = READY._replace(time_s=30.0)
    later = [ran(n, REQUEST._replace(time_s=1.0 + n), READY) for n in (1, 2)]
    before = reports.report([*later, ran(3, REQUEST), ran(4, *RUN), ran(6)])
    moved = [ran(1, REQUEST._replace(time_s=2.0), late), ran(2, REQUEST._replace(time_s=3.0), late)]
    now = reports.report([*moved, ran(3), ran(4, *RUN), ran(5, *RUN), reports.result(6)])
    baseline = read_baseline(kept(before, tmp_path), "toy")
    changes = compare_behaviour(now, baseline, whole=True)
    assert [(kind.kind, kind.tests) for kind in changes.kinds] == [
        ("`leg_ready` later", 2),
        ("`request` is missing", 1),
    ]
    assert changes.kinds[0].example == "test_toy.py::test_toy[rl-leg1]"
    assert (changes.compared, changes.new) == (4, ("rl-leg5",))
    assert headline(changes) == "3 of 4 tests behave differently from the baseline"
    fewer = reports.report([ran(4, *RUN)])
    assert compare_behaviour(fewer, baseline, whole=True).removed == ("rl-leg1", "rl-leg2", "rl-leg3", "rl-leg6")
    assert compare_behaviour(fewer, baseline, whole=False).removed == ()


def notes(before: Report, now: Report, folder: Path) -> tuple[str, ...]:
    return compare_behaviour(now, read_baseline(kept(before, folder), "toy"), whole=True).notes


def test_notes_say_what_can_be_the_cause(tmp_path: Path) -> None:
    before, changed = reports.report([ran(1, *RUN)]), reports.report([ran(1, REQUEST)])
    (same_code,) = notes(before, changed, tmp_path)
    assert same_code.startswith("the code under test is the same as before, so the testbench")
    other_code = replace(changed, code_under_test=replace(changed.code_under_test, sha256="00"))
    assert notes(before, other_code, tmp_path) == ()
    unnoticed = replace(before, code_under_test=replace(before.code_under_test, sha256="00"))
    assert notes(before, unnoticed, tmp_path) == ("the code under test has changed, but no test behaves differently",)
    older, newer = (replace(other_code, environment={"python": version}) for version in ("3.11", "3.12"))
    before = replace(before, environment=older.environment)
    assert notes(before, older, tmp_path) == ()
    (versions,) = notes(before, newer, tmp_path)
    assert versions.startswith("python was 3.11 before, and is 3.12 now")
