"""What streams say: few things, each for a while."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate, product

from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.extra.suggestion.contents import _steps, changes, content_events, contents, held_contents
from pytest_hricdv.extra.suggestion.mining import candidates
from pytest_hricdv.extra.suggestion.stored_run import StoredMessage, StoredRun
from pytest_hricdv.extra.suggestion.views import Runs
from pytest_hricdv.monitor import Requirement, Vocabulary, evaluate, parse_formula

VOCABULARY = Vocabulary(messages={"drive": {"turn": float, "is_on": bool, "gear": str}, "order": {}, "done": {}})

TABLE = ((0.0, 0.0, False, "N"), (2.0, 1 / 3, True, "D"), (5.0, -0.3, True, "R"), (9.0, 0.0, False, "N"))
"""From when (s) on a robot says what, 20 times a second, after an order."""


def driving(name: str, order_s: float, table: Sequence[tuple[float, float, bool, str]] = TABLE) -> StoredRun:
    messages = [StoredMessage(order_s, "person", "order", {})]
    for step in range(300):
        _, turn, is_on, gear = [row for row in table if row[0] <= step / 20][-1]
        fields: dict[str, bool | int | float | str] = {"turn": turn, "is_on": is_on, "gear": gear}
        messages.append(StoredMessage(order_s + step / 20, "robot", "drive", fields))
    return StoredRun(
        test=name, sha256=name, end_s=order_s + 20.0, messages=tuple(messages), own_topics=("drive", "done")
    )


def runs(*made: StoredRun) -> Runs:
    return Runs.of(made or [driving(f"test-{number}", 1.0 + number) for number in range(3)], VOCABULARY, ("person",))


def test_what_a_stream_says_for_a_while_is_an_event_when_it_begins() -> None:
    times = {event.text: event.times[0] for event in content_events(runs())}
    assert times["rise(drive.turn == 0.3333333333333333)"] == (3.0,)
    assert times['rise(drive.gear == "N")'] == (1.0, 10.0)
    assert times["rise(drive.is_on)"] == (3.0,)
    assert times["rise(!drive.is_on)"] == (1.0, 10.0)


def test_it_says_nothing_else_and_each_in_its_time() -> None:
    made = {candidate.candidate.formula for candidate in candidates(runs())}
    assert "always(on(drive) -> drive.turn == -0.3 | drive.turn == 0 | drive.turn == 0.3333333333333333)" in made
    assert any(
        formula.startswith("always(rise(drive.turn == 0.3333333333333333) -> eventually[2.7:3.3](rise(drive.turn"
                           " == -0.3)") for formula in made
    )  # fmt: skip


def test_it_changes_as_it_did_only() -> None:
    assert (
        'always(on(drive) & drive.gear != last(drive.gear) -> last(drive.gear) == "D" & drive.gear == "R" | '
        'last(drive.gear) == "N" & drive.gear == "D" | last(drive.gear) == "R" & drive.gear == "N")'
    ) in {candidate.formula for candidate in changes(runs())}


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 2)), min_size=2, max_size=30))
def test_changes_are_those_that_a_monitor_judges(steps: list[tuple[int, int]]) -> None:
    """Several messages may come at one instant."""
    times = accumulate(step for step, _ in steps)
    log = StoredRun(test="one", end_s=100.0, messages=tuple(
        StoredMessage(float(time_s), "robot", "drive", {"turn": float(value), "is_on": False, "gear": "N"})
        for time_s, (_, value) in zip(times, steps, strict=True)
    ))  # fmt: skip
    seen = {*_steps(log.messages, "turn")}
    for pair in product((0.0, 1.0, 2.0), repeat=2):
        if pair[0] != pair[1]:
            text = f"always(on(drive) & last(drive.turn) == {pair[0]} -> drive.turn != {pair[1]})"
            [verdict] = evaluate([Requirement("R", "", "", text, parse_formula(text, VOCABULARY))], log.log())
            assert (verdict.verdict == "Failed") == (pair in seen), pair


def test_a_measured_number_and_one_of_a_single_run_are_no_choice_of_the_code() -> None:
    measured = [driving(f"test-{number}", 1.0, [(0.05 * s, 0.001 * s, False, "N") for s in range(300)])
                for number in range(3)]  # fmt: skip
    assert held_contents(runs(*measured), "drive", "turn") == []
    other = [driving(f"test-{number}", 1.0, [(0.0, 0.1 * number, False, "N")]) for number in range(3)]
    assert contents(runs(*other), "drive", "turn") == []


def test_what_does_not_come_often_is_no_stream() -> None:
    few = [StoredRun(test="one", sha256="one", end_s=9.0, own_topics=("drive",), messages=tuple(
        StoredMessage(float(step), "robot", "drive", {"turn": 0.0, "is_on": False, "gear": "N"}) for step in range(9)
    ))]  # fmt: skip
    assert contents(runs(*few), "drive", "turn") == [0.0]
    assert held_contents(runs(*few), "drive", "turn") == []
    assert not [*content_events(runs(*few))]
