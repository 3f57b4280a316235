"""Every operator and every kind of response, at and around its boundaries."""

from __future__ import annotations

import pytest

from pytest_hricdv.monitor import Verdict
from tests.monitor.vocabulary import Update, judge

NO_P: Update = (0.0, "p", False)
MESSAGE: dict[str, float | bool] = {}


def at(name: str, *times_s: float) -> list[Update]:
    return [(time_s, name, MESSAGE) for time_s in times_s]


def during(name: str, *spans: tuple[float, float]) -> list[Update]:
    """A boolean signal, false from 0 s, true in the half-open spans."""
    updates: list[Update] = [] if spans and spans[0][0] == 0 else [(0.0, name, False)]
    for start_s, end_s in spans:
        updates += [(start_s, name, True), (end_s, name, False)]
    return updates


def in_time(*updates: list[Update]) -> list[Update]:
    return sorted((update for some in updates for update in some), key=lambda update: update[0])


def times(verdict: Verdict) -> list[float]:
    return [violation.time_s for violation in verdict.violations]


def counts(verdict: Verdict) -> tuple[str, int, int, int, int]:
    return verdict.verdict, verdict.attempts, verdict.passes, verdict.failures, verdict.pending


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
        assert [(each.trigger_s, each.values) for each in verdict.violations] == [
            (1.0, {"p": False, formula.partition(" ")[0]: 2})
        ]
    assert judge("always(on(a) -> count(on(a)) <= 1)", updates, 3.0).margin == -2.0
    # A condition that holds at the instant becomes true once, however many messages there are.
    assert judge("always(count(on(a) & !p) > 2 -> p)", updates, 3.0).attempts == 0


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


@pytest.mark.parametrize(
    ("formula", "triggers"),
    [
        ("x < 1", [0.0, 3.0]),
        ("x <= 1", [0.0, 3.0]),
        ("x > 1", [2.0]),
        ("x >= 1", [1.0]),
        ("x == 1", [1.0]),
        ("x != 1", [0.0, 2.0]),
        ("-x < -1", [2.0]),
        ("x + 1 >= 2 * 1.5", [2.0]),
        ("(x - 2) / 2 == 0", [2.0]),
        ("x - 1 - 1 == 0", [2.0]),
        ("(x > 1) & !(x > 2)", [2.0]),
        ("x >= 1 [for 1]", [2.0]),
        ("x >= 1 [for 1.5]", [2.5]),
        ("x >= 1 [for 2]", []),
        ("x < 1 [hysteresis 0.5]", [0.0, 3.0]),
        ("x < 1 [hysteresis 1]", [0.0]),
        ("x > 0 [hysteresis 1]", [2.0]),
    ],
)
def test_a_comparison_is_true_exactly_at_its_times(formula: str, triggers: list[float]) -> None:
    updates: list[Update] = [NO_P, (0.0, "x", 0.0), (1.0, "x", 1.0), (2.0, "x", 2.0), (3.0, "x", 0.0)]
    verdict = judge(f"always({formula} -> p)", updates, 4.0)
    assert [violation.trigger_s for violation in verdict.violations] == triggers


@pytest.mark.parametrize(
    ("formula", "triggers"),
    [
        ('s == "i"', [0.0, 3.0]),
        ('s != "i"', [2.0]),
        ('s == "i" [for 1.5]', [1.5]),
        ('w == "i"', [1.0, 4.0]),
        ('w != "i"', [2.0]),  # not before the first message
        ('!(w == "i")', [0.0, 2.0]),
        ("w == s", [1.0, 4.0]),
        ("w != s", [3.0]),
        ('rise(w == "i")', [1.0, 4.0]),
        ('on(w) & w == "i"', [1.0, 4.0]),
        ('w == "i" [for 1]', []),
    ],
)
def test_a_comparison_of_texts_is_true_exactly_at_its_times(formula: str, triggers: list[float]) -> None:
    updates: list[Update] = [
        NO_P,
        (0.0, "s", "i"),
        (1.0, "w", {"name": "i"}),
        (2.0, "s", "j"),
        (2.0, "w", {"name": "j"}),
    ]
    updates += [(3.0, "s", "i"), (4.0, "w", {"name": "i"})]
    verdict = judge(f"always({formula} -> p)", updates, 4.25)
    assert [violation.trigger_s for violation in verdict.violations] == triggers


def test_a_comparison_of_texts_has_no_margin_and_its_values_are_reported() -> None:
    updates: list[Update] = [(0.0, "p", True), (0.0, "x", 1.0), (1.0, "w", {"name": "j"})]
    verdict = judge('always(on(w) -> w == "i" & x > 0.5)', updates, 2.0)
    [violation] = verdict.violations
    assert (violation.values, violation.margin) == ({"w.name": "j", "x": 1.0}, None)
    # What compares numbers beside texts has their margin while the texts allow it.
    assert judge('always(p -> x < 3 & s == "i")', [*updates[:2], (0.0, "s", "i")], 2.0).margin == 2.0


def test_the_first_value_of_a_signal_is_not_an_edge_and_a_first_message_is() -> None:
    assert judge("always(rise(q) -> p)", [NO_P, (0.0, "q", True)], 1.0).attempts == 0
    assert judge("always(rise(once[0:1](on(a))) -> p)", [NO_P, *at("a", 0.0)], 1.0).attempts == 1


def test_an_antecedent_true_from_the_start_is_an_attempt() -> None:
    assert counts(judge("always(!on(a) -> q)", [(0.0, "q", True)], 3.0)) == ("Passed", 1, 1, 0, 0)


# --- state responses


def test_an_episode_with_several_violations_is_one_failure() -> None:
    updates = in_time([(0.0, "x", 1.0)], during("p", (1.0, 5.0)), [(2.0, "x", 0.0), (3.0, "x", 1.0), (4.0, "x", -1.0)])
    verdict = judge("always(p -> x > 0.5)", updates, 6.0)
    assert counts(verdict) == ("Failed", 1, 0, 1, 0)
    assert [(v.trigger_s, v.time_s, v.margin) for v in verdict.violations] == [(1.0, 2.0, -0.5), (1.0, 4.0, -1.5)]
    assert verdict.violations[0].values == {"p": True, "x": 0.0}
    assert (verdict.margin, verdict.margin_time_s) == (-1.5, 4.0)


def test_a_violation_from_before_the_episode_begins_with_it() -> None:
    verdict = judge("always(p -> x > 0.5)", in_time([(0.0, "x", 0.0)], during("p", (1.0, 2.0))), 6.0)
    assert times(verdict) == [1.0]


@pytest.mark.parametrize(
    ("relation", "verdict"), [("<", "Failed"), ("<=", "Passed"), (">", "Failed"), (">=", "Passed")]
)
def test_at_the_bound_the_comparison_decides_and_the_margin_is_zero(relation: str, verdict: str) -> None:
    result = judge(f"always(p -> x {relation} 0.25)", [(0.0, "p", True), (0.0, "x", 0.25)], 1.0)
    assert (result.verdict, result.margin) == (verdict, 0.0)


def test_hysteresis_merges_the_edges_of_a_noisy_violation() -> None:
    noise = [0.06, 0.0499, 0.0505, 0.0499, 0.0549, 0.0499, 0.0551, 0.06, 0.0499, 0.06]
    updates: list[Update] = [(0.0, "p", True), *((float(i), "x", value) for i, value in enumerate(noise))]
    assert times(judge("always(p -> x >= 0.05 [hysteresis 0.005])", updates, 12.0)) == [1.0, 8.0]
    assert times(judge("always(p -> x >= 0.05)", updates, 12.0)) == [1.0, 3.0, 5.0, 8.0]


def test_hysteresis_is_reset_at_the_start_of_an_episode() -> None:
    updates = in_time([(0.0, "x", 0.0), (1.0, "x", 0.051)], during("p", (2.0, 3.0)))
    assert judge("always(p -> x >= 0.05 [hysteresis 0.005])", updates, 4.0).verdict == "Passed"


def test_hysteresis_keeps_noise_from_splitting_an_episode() -> None:
    noise = [0.0, 0.1, 0.002, 0.0009, 0.002, 0.0009, 0.1, 0.0]
    updates: list[Update] = [(float(i), "x", value) for i, value in enumerate(noise)]
    assert judge("always(x > 0.001 [hysteresis 0.004] -> x < 0.25)", updates, 9.0).attempts == 2
    assert judge("always(x > 0.001 -> x < 0.25)", updates, 9.0).attempts == 3


def test_a_boolean_response_has_no_margin() -> None:
    verdict = judge("always(p -> q)", [(0.0, "p", True), (0.0, "q", False)], 1.0)
    assert (verdict.verdict, verdict.margin, verdict.violations[0].margin) == ("Failed", None, None)


def test_an_episode_that_is_open_at_the_end_has_passed() -> None:
    assert counts(judge("always(p -> q)", [(0.0, "p", True), (0.0, "q", True)], 1.0)) == ("Passed", 1, 1, 0, 0)


def test_the_last_instant_of_the_run_is_judged_and_the_time_after_it_is_not() -> None:
    assert (
        judge("always(p -> !previously(q))", in_time([(0.0, "p", True)], during("q", (1.0, 9.0)))[:-1], 1.0).failures
        == 0
    )
    assert judge("always(p -> !q)", in_time([(0.0, "p", True)], during("q", (1.0, 9.0)))[:-1], 1.0).failures == 1


# --- eventually

RESPOND = "always(on(a) -> eventually[1:3](on(b)))"


@pytest.mark.parametrize(
    ("answer_s", "end_s", "expected"),
    [
        (10.9, 20.0, ("Failed", 1, 0, 1, 0)),
        (11.0, 20.0, ("Passed", 1, 1, 0, 0)),
        (13.0, 20.0, ("Passed", 1, 1, 0, 0)),
        (13.0, 13.0, ("Passed", 1, 1, 0, 0)),
        (13.001, 20.0, ("Failed", 1, 0, 1, 0)),
    ],
)
def test_a_window_includes_its_ends(answer_s: float, end_s: float, expected: tuple[str, int, int, int, int]) -> None:
    assert counts(judge(RESPOND, in_time(at("a", 10.0), at("b", answer_s)), end_s)) == expected


def test_the_window_is_measured_without_rounding_noise() -> None:
    assert (
        judge("always(on(a) -> eventually[0:0.2](on(b)))", [*at("a", 0.1), *at("b", 0.1 + 0.2)], 1.0).verdict
        == "Passed"
    )


def test_a_missed_deadline_is_a_violation_at_the_deadline_without_an_update() -> None:
    verdict = judge(RESPOND, at("a", 10.0), 99.0)
    [violation] = verdict.violations
    assert (violation.trigger_s, violation.time_s, violation.margin) == (10.0, 13.0, 0.0)
    assert (verdict.margin, verdict.margin_time_s) == (0.0, 13.0)


def test_a_deadline_at_the_very_end_is_decided_and_one_after_it_is_pending() -> None:
    assert counts(judge(RESPOND, at("a", 10.0), 13.0)) == ("Failed", 1, 0, 1, 0)
    assert counts(judge(RESPOND, at("a", 10.0), 12.999)) == ("NC", 1, 0, 0, 1)


def test_a_pass_and_a_pending_attempt_are_passed() -> None:
    assert counts(judge(RESPOND, in_time(at("a", 1.0, 10.0), at("b", 2.0)), 11.0)) == ("Passed", 2, 1, 0, 1)


def test_the_margin_is_the_least_time_left() -> None:
    verdict = judge(RESPOND, in_time(at("a", 0.0, 10.0), at("b", 1.5, 12.75)), 20.0)
    assert (verdict.margin, verdict.margin_time_s) == (0.25, 12.75)


def test_a_state_that_holds_when_the_window_opens_discharges_then() -> None:
    verdict = judge("always(on(a) -> eventually[1:3](p))", in_time([(0.0, "p", True)], at("a", 10.0)), 20.0)
    assert (verdict.margin, verdict.margin_time_s) == (2.0, 11.0)


def test_one_event_discharges_all_open_attempts() -> None:
    assert counts(judge(RESPOND, in_time(at("a", 1.0, 1.5, 2.0), at("b", 3.5)), 9.0)) == ("Passed", 3, 3, 0, 0)


# --- always[a:b] and until


@pytest.mark.parametrize(
    ("dip", "end_s", "expected"),
    [
        ((10.5, 10.9), 20.0, ("Passed", 1, 1, 0, 0)),
        ((10.5, 11.0), 20.0, ("Passed", 1, 1, 0, 0)),
        ((10.5, 11.001), 20.0, ("Failed", 1, 0, 1, 0)),
        ((13.0, 14.0), 20.0, ("Failed", 1, 0, 1, 0)),
        ((13.001, 14.0), 20.0, ("Passed", 1, 1, 0, 0)),
        ((15.0, 16.0), 12.0, ("Passed", 1, 1, 0, 0)),  # the window has begun: an open safety obligation is discharged
        ((15.0, 16.0), 10.5, ("NC", 1, 0, 0, 1)),  # it has not: nothing was checked
    ],
)
def test_always_within(dip: tuple[float, float], end_s: float, expected: tuple[str, int, int, int, int]) -> None:
    updates = [u for u in in_time(during("p", dip), at("a", 10.0)) if u[0] <= end_s]
    assert counts(judge("always(on(a) -> always[1:3](!p))", updates, end_s)) == expected


UNTIL = "always(on(a) -> always(!p) until on(b))"


@pytest.mark.parametrize(
    ("breach_s", "release_s", "expected"),
    [
        (12.0, 13.0, ("Failed", 1, 0, 1, 0)),
        (14.0, 13.0, ("Passed", 1, 1, 0, 0)),
        (13.0, 13.0, ("Passed", 1, 1, 0, 0)),  # at the release it need not hold any more
        (10.0, 13.0, ("Failed", 1, 0, 1, 0)),  # at the trigger it has to
        (9.0, 13.0, ("Failed", 1, 0, 1, 0)),
        (12.0, 10.0, ("Passed", 1, 1, 0, 0)),
        (90.0, 90.0, ("Passed", 1, 1, 0, 0)),  # to the end of the run
    ],
)
def test_until(breach_s: float, release_s: float, expected: tuple[str, int, int, int, int]) -> None:
    updates = [u for u in in_time(during("p", (breach_s, 99.0)), at("a", 10.0), at("b", release_s)) if u[0] <= 20.0]
    assert counts(judge(UNTIL, updates, 20.0)) == expected


def test_each_open_attempt_of_an_until_fails_by_itself() -> None:
    verdict = judge(UNTIL, in_time(during("p", (5.0, 6.0)), at("a", 1.0, 2.0)), 9.0)
    assert [(violation.trigger_s, violation.time_s) for violation in verdict.violations] == [(1.0, 5.0), (2.0, 5.0)]


# --- instants


def test_messages_at_two_instants_are_two_attempts_and_at_one_instant_one() -> None:
    assert judge(RESPOND, at("a", 1.0, 2.0), 9.0).attempts == 2
    assert judge(RESPOND, at("a", 1.0, 1.0), 9.0).attempts == 1


def test_of_several_messages_at_one_instant_the_last_counts() -> None:
    text = "always(on(m) & m.ok -> p)"
    bad: dict[str, float | bool] = {"ok": True, "level": 0.0}
    good: dict[str, float | bool] = {"ok": False, "level": 0.0}
    assert judge(text, [NO_P, (1.0, "m", bad), (1.0, "m", good)], 2.0).attempts == 0
    assert judge(text, [NO_P, (1.0, "m", good), (1.0, "m", bad)], 2.0).failures == 1


def test_an_instant_is_judged_after_all_its_updates() -> None:
    updates: list[Update] = [(0.0, "x", 0.0), NO_P, (1.0, "p", True), (1.0, "x", 1.0)]
    assert judge("always(p -> x > 0.5)", updates, 2.0).verdict == "Passed"


def test_a_message_exists_only_at_its_instant() -> None:
    updates = in_time(during("p", (3.0, 4.0)), at("b", 1.0), at("a", 2.0))
    assert judge(UNTIL, updates, 5.0).verdict == "Failed"


def test_a_message_counts_at_the_instant_at_which_a_window_starts_an_attempt() -> None:
    # `a` is not read before the attempt, which the end of a window starts, not an update.
    text = "always(fall(once[0:2](p)) -> on(a))"
    dip = during("p", (1.0, 2.0))
    assert judge(text, in_time(dip, at("a", 4.0), at("b", 5.0)), 9.0).verdict == "Passed"
    assert judge(text, in_time(dip, at("a", 3.9), at("b", 5.0)), 9.0).verdict == "Failed"
    assert judge(text, in_time(dip, at("a", 4.0)), 4.0).verdict == "Passed"


def test_nothing_triggered_is_not_checked_and_vacuous() -> None:
    verdict = judge("always(p -> q)", [NO_P, (0.0, "q", False)], 5.0)
    assert (verdict.verdict, verdict.attempts, verdict.vacuous) == ("NC", 0, 1)
