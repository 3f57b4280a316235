"""Orders between messages, and what tells messages apart, of runs whose behaviour is known."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from dataclasses import replace

from msgspec import structs

from pytest_hricdv.extra.suggestion.guards import guards
from pytest_hricdv.extra.suggestion.occurrences import events_of, signal_conditions
from pytest_hricdv.extra.suggestion.orders import precedences
from pytest_hricdv.extra.suggestion.stored_run import StoredMessage, StoredRun
from pytest_hricdv.extra.suggestion.views import Runs, copied
from pytest_hricdv.monitor import Vocabulary

VOCABULARY = Vocabulary(
    signals={"cup": bool, "level": float},
    messages={"order": {}, "tap": {"what": str}, "gave_up": {}},
    values={"tap.what": ("open", "close")},
)


def pouring(name: str, orders: Sequence[tuple[float, bool, float]]) -> StoredRun:
    """Orders, each with its time (s), whether there is a cup, and its level: the tap is open for 5 s, and then the
    robot gives up; without a cup it does at once."""
    messages: list[StoredMessage] = []
    cups, levels = [(0.0, 1.0)], [(0.0, 10.0)]
    for time_s, has_cup, level in orders:
        messages.append(StoredMessage(time_s, "person", "order", {}))
        cups.append((time_s - 1.0, float(has_cup)))
        levels.append((time_s - 1.0, level))
        ends_s = time_s + 5.0 if has_cup else time_s
        if has_cup:
            messages.append(StoredMessage(time_s, "robot", "tap", {"what": "open"}))
            messages.append(StoredMessage(ends_s, "robot", "tap", {"what": "close"}))
        messages.append(StoredMessage(ends_s + 0.3, "robot", "gave_up", {}))
    signals = {
        signal: (array("d", [at for at, _ in changes]).tobytes(), array("d", [v for _, v in changes]).tobytes())
        for signal, changes in (("cup", cups), ("level", levels))
    }
    return StoredRun(
        test=name, sha256=name, end_s=200.0, signals=signals, messages=tuple(messages),
        own_topics=("gave_up", "tap"), other_signals=("cup", "level"),
    )  # fmt: skip


def runs() -> Runs:
    levels = (80.0, 95.0, 20.0, 10.0, 90.0, 15.0)
    made = [
        pouring(f"test-{shift}", [(20.0 * (n + 1) + shift, n % 2 == 1, level) for n, level in enumerate(levels)])
        for shift in range(4)
    ]
    return Runs.of(made, VOCABULARY, ("person",))


def formulas() -> set[str]:
    made = runs()
    return {candidate.formula for candidate in precedences(made, events_of(made))}


def test_a_value_of_a_message_comes_after_another_one() -> None:
    assert (
        'always(on(tap) & tap.what == "close" -> previously(!(on(tap) & tap.what == "close") since '
        '(on(tap) & tap.what == "open")))' in formulas()
    )


def test_messages_come_no_more_often_than_what_asks_for_them() -> None:
    assert "always(on(gave_up) -> count(on(gave_up)) <= count(on(order)))" in formulas()
    assert not [formula for formula in formulas() if "count(on(gave_up)) <= count(on(tap))" in formula]


def test_what_a_robot_says_is_told_apart_by_what_only_people_change() -> None:
    assert any(formula.startswith("always(on(gave_up) & cup -> time_since(") for formula in formulas())


def test_a_number_in_two_groups_tells_messages_apart_and_one_in_a_single_group_does_not() -> None:
    texts = {condition.text for condition in signal_conditions(runs())}
    assert {"level >= 50", "level < 50"} <= texts
    even = Runs.of(
        [pouring("even", [(20.0 * n, True, level) for n, level in enumerate((10, 20, 30, 40, 50), 1)])],
        VOCABULARY,
        ("person",),
    )
    assert not [condition for condition in signal_conditions(even) if condition.text.startswith("level <")]


def test_a_signal_that_repeats_what_messages_say_is_told_and_one_that_does_not_is_not() -> None:
    of_pouring = pouring("one", [(20.0, True, 10.0), (40.0, False, 80.0)])
    taps = [message for message in of_pouring.messages if message.topic == "tap"]
    times = array("d", [0.0, *(message.time_s for message in taps)]).tobytes()
    said = (times, ["", *(str(message.fields["what"]) for message in taps)])
    other = (times, ["", "open", "open"])
    repeated = structs.replace(of_pouring, texts={"said_tap_what": said, "other": other})
    vocabulary = replace(VOCABULARY, signals={**VOCABULARY.signals, "said_tap_what": str, "other": str})
    assert copied([repeated], vocabulary) == {"said_tap_what"}


def test_what_tells_an_event_apart_is_not_asked_of_it() -> None:
    levels = (5.0, 10.0, 20.0, 80.0, 95.0, 90.0)
    made = Runs.of(
        [pouring(f"test-{shift}", [(20.0 * n + shift, n % 2 == 1, level) for n, level in enumerate(levels, 1)])
         for shift in range(4)],
        VOCABULARY,
        ("person",),
    )  # fmt: skip
    events = [event for event in events_of(made) if event.author == "robot" and event.text.startswith("on(")]
    told_apart = {event.text for event in events}
    assert {"on(gave_up) & cup", "on(gave_up) & level >= 50"} <= told_apart
    for event in events:
        for candidate in guards(made, [event]):
            name = candidate.response.lstrip("!").partition(" ")[0]
            assert f"& {name}" not in event.text.replace("!", ""), candidate.formula
