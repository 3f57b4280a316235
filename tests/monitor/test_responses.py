"""Every kind of response, at and around its boundaries."""

from __future__ import annotations

import pytest

from tests.monitor.updates import NO_P, at, counts, during, in_time
from tests.monitor.vocabulary import Update, judge

# --- state responses


def test_an_episode_with_several_violations_is_one_failure() -> None:
    updates = in_time([(0.0, "x", 1.0)], during("p", (1.0, 5.0)), [(2.0, "x", 0.0), (3.0, "x", 1.0), (4.0, "x", -1.0)])
    verdict = judge("always(p -> x > 0.5)", updates, 6.0)
    assert counts(verdict) == ("Failed", 1, 0, 1, 0)
    assert [(v.trigger_s, v.time_s, v.margin) for v in verdict.violations] == [(1.0, 2.0, -0.5), (1.0, 4.0, -1.5)]
    assert verdict.violations[0].values == {"p": True, "x": 0.0}
    assert (verdict.margin, verdict.margin_time_s) == (-1.5, 4.0)


@pytest.mark.parametrize(
    ("relation", "verdict"), [("<", "Failed"), ("<=", "Passed"), (">", "Failed"), (">=", "Passed")]
)
def test_at_the_bound_the_comparison_decides_and_the_margin_is_zero(relation: str, verdict: str) -> None:
    result = judge(f"always(p -> x {relation} 0.25)", [(0.0, "p", True), (0.0, "x", 0.25)], 1.0)
    assert (result.verdict, result.margin) == (verdict, 0.0)


def test_hysteresis_keeps_noise_from_splitting_an_episode() -> None:
    noise = [0.0, 0.1, 0.002, 0.0009, 0.002, 0.0009, 0.1, 0.0]
    updates: list[Update] = [(float(i), "x", value) for i, value in enumerate(noise)]
    assert judge("always(x > 0.001 [hysteresis 0.004] -> x < 0.25)", updates, 9.0).triggers == 2
    assert judge("always(x > 0.001 -> x < 0.25)", updates, 9.0).triggers == 3


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


def test_a_missed_deadline_is_a_violation_at_the_deadline_without_an_update() -> None:
    verdict = judge(RESPOND, at("a", 10.0), 99.0)
    [violation] = verdict.violations
    assert (violation.trigger_s, violation.time_s) == (10.0, 13.0)


def test_the_margin_of_a_missed_deadline_is_how_late_the_response_came() -> None:
    late = judge(RESPOND, in_time(at("a", 10.0), at("b", 17.5)), 99.0)
    assert (late.margin, late.margin_time_s, late.violations[0].margin) == (-4.5, 17.5, -4.5)
    never = judge(RESPOND, at("a", 10.0), 99.0)
    assert (never.margin, never.margin_time_s, never.violations[0].margin) == (-86.0, 99.0, -86.0)
    at_the_end = judge(RESPOND, at("a", 10.0), 13.0)
    assert (at_the_end.margin, at_the_end.margin_time_s) == (0.0, 13.0)
    twice = judge(RESPOND, in_time(at("a", 10.0, 12.0), at("b", 16.0)), 99.0)
    assert (twice.margin, [violation.margin for violation in twice.violations]) == (-3.0, [-3.0, -1.0])


def test_a_deadline_at_the_very_end_is_decided_and_one_after_it_is_pending() -> None:
    assert counts(judge(RESPOND, at("a", 10.0), 13.0)) == ("Failed", 1, 0, 1, 0)
    assert counts(judge(RESPOND, at("a", 10.0), 12.999)) == ("NC", 1, 0, 0, 1)


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


# --- instants


def test_of_several_messages_at_one_instant_the_last_counts() -> None:
    text = "always(on(m) & m.ok -> p)"
    bad: dict[str, float | bool] = {"ok": True, "level": 0.0}
    good: dict[str, float | bool] = {"ok": False, "level": 0.0}
    assert judge(text, [NO_P, (1.0, "m", bad), (1.0, "m", good)], 2.0).triggers == 0
    assert judge(text, [NO_P, (1.0, "m", good), (1.0, "m", bad)], 2.0).failures == 1


def test_a_message_counts_at_the_instant_at_which_a_window_starts_a_trigger() -> None:
    # `a` is not read before the trigger, which the end of a window starts, not an update.
    text = "always(fall(once[0:2](p)) -> on(a))"
    dip = during("p", (1.0, 2.0))
    assert judge(text, in_time(dip, at("a", 4.0), at("b", 5.0)), 9.0).verdict == "Passed"
    assert judge(text, in_time(dip, at("a", 3.9), at("b", 5.0)), 9.0).verdict == "Failed"
    assert judge(text, in_time(dip, at("a", 4.0)), 4.0).verdict == "Passed"
