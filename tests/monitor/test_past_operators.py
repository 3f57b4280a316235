"""Every operator about the present and the past, at and around its boundaries."""

from __future__ import annotations

import pytest

from tests.monitor.updates import NO_P, at, during, in_time
from tests.monitor.vocabulary import Update, judge

# --- past operators: the state response `p` fails exactly where an episode of the formula begins, as p is never true


@pytest.mark.parametrize(
    ("formula", "triggers"),
    [
        ("on(a)", [1.0, 2.0]),
        ("q", [3.0, 6.0]),
        ("!q", [0.0, 5.0, 8.0]),
        ("not q", [0.0, 5.0, 8.0]),
        ("q & on(b)", [3.0, 4.0]),
        ("on(a) | on(b)", [1.0, 2.0, 3.0, 4.0, 9.0]),
        ("rise(q)", [3.0, 6.0]),
        ("fall(q)", [5.0, 8.0]),
        ("rise(on(a))", [1.0, 2.0]),
        ("previously(q)", [3.0, 6.0]),  # from right after the edge
        ("once[0:0.5](on(a))", [1.0, 2.0]),
        ("once[0:1](on(a))", [1.0]),  # [1, 2] and [2, 3] touch
        ("once[0.25:0.5](on(a))", [1.25, 2.25]),
        ("fall(once[0:0.5](on(a)))", [1.5, 2.5]),
        ("once(on(b))", [3.0]),
        ("once[0.5:inf](q)", [3.5]),
        ("historically[0:1](q)", [4.0, 7.0]),
        ("historically(!on(b))", [0.0]),
        ("!on(b) since on(a)", [1.0]),
        ("rise(q since on(b))", [3.0, 9.0]),
        ("(q since on(b)) & !(on(a) | on(b))", [3.0, 4.0]),
        ("!q since q", [3.0]),  # from the first q on, one takes over from the other
    ],
)
def test_an_operator_is_true_exactly_at_its_times(formula: str, triggers: list[float]) -> None:
    updates = in_time([NO_P], during("q", (3.0, 5.0), (6.0, 8.0)), at("a", 1.0, 2.0), at("b", 3.0, 4.0, 9.0))
    verdict = judge(f"always({formula} -> p)", updates, 10.0)
    assert [violation.trigger_s for violation in verdict.violations] == triggers


@pytest.mark.parametrize(
    ("formula", "triggers"),
    [
        ("count(on(a)) == 1", [1.0]),
        ("count(on(a)) == 2", [2.0]),
        ("count(on(b)) > 2", [9.0]),
        ("count(q) >= 2", [6.0]),
        ("count(!q) == 1", [5.0]),  # not what is true from the start: that did not become true
        ("count(fall(q)) != count(rise(q))", [3.0, 6.0]),
        ("count(on(a)) + count(on(b)) == 3", [3.0]),
        ("count[0:1](on(a)) == 2", [2.0]),  # both ends of the window belong to it
        ("count[0:0.9](on(a)) == 2", []),
        ("count[0:2.5](on(a)) == 0", [0.0, 4.5]),
        ("count[0:2](on(b)) == 1 & !on(b)", [3.0, 5.0, 9.0]),  # right after 5 s, the message of 3 s is out
        ("count[1:1.5](on(a)) == 1", [2.0, 3.0]),
        ("count[0:1](on(b)) < 2 [for 3]", [3.0, 7.0]),  # false at the instant 4 s
        ("time_since(on(a)) < 0.5", [1.0, 2.0]),
        ("time_since(on(a)) <= 1", [1.0]),
        ("time_since(on(a)) > 1", [0.0, 3.0]),  # from right after 3 s
        ("time_since(on(a)) >= 1", [0.0, 3.0]),
        ("1 >= time_since(q)", [3.0]),
        ("1 > time_since(q)", [3.0]),
        ("time_since(!q) >= 1.5", [4.5, 7.5]),
        ("on(b) & time_since(on(a)) < 2", [3.0]),
        ("on(b) & time_since(on(a)) <= 2", [3.0, 4.0]),
        ("time_between(on(a), on(b)) == 1", [3.0]),
        ("time_between(on(a), on(b)) != 1", [4.0]),  # without a value, this is false, too
        ("time_between(on(b), on(a)) >= 0", []),
        ("time_between(on(a), on(b)) - time_between(q, on(b)) < 1.5", [3.0]),
        ("time_between(q, !q) == 2", [5.0]),
        ("time_between(on(b), q) == 0", [3.0]),
        ("time_between(q, on(a)) < 9 | time_between(on(a), q) >= 4", [6.0]),
        ("time_between(on(a), on(b)) < 3 [for 2]", [5.0]),
    ],
)
def test_counts_and_times_change_exactly_at_their_times(formula: str, triggers: list[float]) -> None:
    updates = in_time([NO_P], during("q", (3.0, 5.0), (6.0, 8.0)), at("a", 1.0, 2.0), at("b", 3.0, 4.0, 9.0))
    verdict = judge(f"always({formula} -> p)", updates, 10.0)
    assert [violation.trigger_s for violation in verdict.violations] == triggers


def test_two_messages_at_one_instant_are_counted_as_two() -> None:
    updates: list[Update] = [NO_P, *at("a", 1.0, 1.0, 2.0)]
    for formula in ("count(on(a)) == 2", "count[0:0.5](on(a)) == 2"):
        verdict = judge(f"always({formula} -> p)", updates, 3.0)
        assert [(violation.trigger_s, violation.values) for violation in verdict.violations] == [
            (1.0, {"p": False, formula.partition(" ")[0]: 2})
        ]
    assert judge("always(on(a) -> count(on(a)) <= 1)", updates, 3.0).margin == -2.0
    # A condition that holds at the instant becomes true once, however many messages there are.
    assert judge("always(count(on(a) & !p) > 2 -> p)", updates, 3.0).triggers == 0


def level(time_s: float, value: float, ok: bool = True) -> Update:
    return time_s, "m", {"ok": ok, "level": value}


@pytest.mark.parametrize(
    ("formula", "triggers"),
    [
        ("last(m.level) == 1", [2.0]),
        ("m.level != last(m.level)", [2.0, 4.0]),  # not at the first message, which has none before it
        ("last(m.level) < 9", [2.0]),
        ("last(m.ok)", [2.0, 4.0]),
        ("!last(m.ok)", [0.0, 3.0]),
        ("last(m.level) - m.level < 0", [2.0]),
        ("rise(last(m.level) == 1)", [2.0]),
        ('last(w) == "i"', [3.0]),
        ("w != last(w)", [3.0]),
    ],
)
def test_last_is_the_value_of_the_message_before(formula: str, triggers: list[float]) -> None:
    updates = [NO_P, level(1.0, 1.0), level(2.0, 2.0, ok=False), level(3.0, 2.0), level(4.0, 1.0)]
    updates += [(1.5, "w", {"name": "i"}), (3.0, "w", {"name": "j"})]
    verdict = judge(f"always({formula} -> p)", in_time(updates), 4.5)
    assert [violation.trigger_s for violation in verdict.violations] == triggers


def test_the_message_before_may_have_come_at_the_same_instant() -> None:
    verdict = judge("always(last(m.level) == 1 -> p)", [NO_P, level(1.0, 1.0), level(1.0, 2.0)], 2.0)
    assert verdict.violations[0].values == {"last(m.level)": 1.0, "p": False}


def test_a_comparison_without_a_message_before_has_no_margin() -> None:
    assert judge("always(on(m) -> last(m.level) < 3)", [level(1.0, 1.0)], 2.0).margin is None
    assert judge("always(on(m) -> last(m.level) < 3)", [level(1.0, 1.0), level(2.0, 9.0)], 3.0).failures == 1
    assert (
        judge("always(on(m) & count(on(m)) > 1 -> last(m.level) < 3)", [level(1.0, 1.0), level(2.0, 9.0)], 3.0).margin
        == 2
    )


def test_a_comparison_of_texts_has_no_margin_and_its_values_are_reported() -> None:
    updates: list[Update] = [(0.0, "p", True), (0.0, "x", 1.0), (1.0, "w", {"name": "j"})]
    verdict = judge('always(on(w) -> w == "i" & x > 0.5)', updates, 2.0)
    [violation] = verdict.violations
    assert (violation.values, violation.margin) == ({"w.name": "j", "x": 1.0}, None)
    # What compares numbers beside texts has their margin while the texts allow it.
    assert judge('always(p -> x < 3 & s == "i")', [*updates[:2], (0.0, "s", "i")], 2.0).margin == 2.0


def test_the_first_value_of_a_signal_is_not_an_edge_and_a_first_message_is() -> None:
    assert judge("always(rise(q) -> p)", [NO_P, (0.0, "q", True)], 1.0).triggers == 0
    assert judge("always(rise(once[0:1](on(a))) -> p)", [NO_P, *at("a", 0.0)], 1.0).triggers == 1
