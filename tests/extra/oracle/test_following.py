"""Runs compared with an agent: what conforms, and what deviates."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.declarations.model_oracle import ActionMapping
from tests.extra.oracle.toy import HANDED_OVER, TOY, Event, Toy, moved, violation, without


@pytest.fixture
def toy(tmp_path: Path) -> Toy:
    return Toy(tmp_path)


def test_a_run_that_does_what_the_agent_does_passes(toy: Toy) -> None:
    verdict = toy.follow(*HANDED_OVER)
    assert (verdict.requirement, verdict.verdict) == ("MODEL", "Passed")
    assert (verdict.triggers, verdict.passes, verdict.pending) == (3, 3, 0)
    assert [(each.begin_s, each.end_s) for each in verdict.history] == [(1.0, 4.0), (4.0, 5.0), (7.0, 7.5)]


def test_an_act_that_is_not_observed_deviates_when_its_time_is_over(toy: Toy) -> None:
    verdict = toy.follow(*without("offer", HANDED_OVER[:5]))
    assert violation(verdict) == (
        "6 s: expected offered within 2 s of 4.0 s (plan @offer of robot, observed by on(offer)); observed nothing"
    )
    assert (verdict.verdict, verdict.failures, verdict.violations[0].trigger_s) == ("Failed", 1, 4.0)


def test_an_act_before_its_time_deviates(toy: Toy) -> None:
    assert violation(toy.follow(*moved("taken", 1.4))) == (
        "1.4 s: expected take(cup) 1 to 10 s after 1.0 s (plan @fetch of robot, observed by on(taken)); "
        'observed taken(thing="cup") after 0.4 s'
    )


@pytest.mark.parametrize(
    ("event", "expected"),
    [
        ((5.5, "offer"), "nothing, as robot waits; observed offer"),
        (
            (2.0, "offer"),
            "take(cup) 1 to 10 s after 1.0 s (plan @fetch of robot, observed by on(taken)); observed offer",
        ),
        ((30.0, "taken", {"thing": "cup"}), 'nothing, as robot waits; observed taken(thing="cup")'),
        ((5.5, "holding", False), "nothing, as robot waits; observed holding = False"),
    ],
    ids=["twice", "in the wrong order", "at the end", "a signal"],
)
def test_an_act_that_the_agent_does_not_do_now_deviates(toy: Toy, event: Event, expected: str) -> None:
    run = sorted((*HANDED_OVER, event), key=lambda each: each[0])
    assert violation(toy.follow(*run)) == f"{event[0]:g} s: expected {expected}"


def test_what_corresponds_to_no_act_is_left_open(toy: Toy) -> None:
    extra: tuple[Event, ...] = (
        (2.0, "state", {"name": "Reset"}),
        (2.0, "weight", 3.0),
        (3.0, "report", {"count": 1.0}),
    )
    assert toy.follow(*sorted((*HANDED_OVER, *extra), key=lambda each: each[0])).verdict == "Passed"


def test_an_act_that_could_still_come_when_the_run_ends_is_pending(toy: Toy) -> None:
    verdict = toy.follow(*HANDED_OVER[:5], (7.0, "thank"), end_s=8.0)
    assert (verdict.verdict, verdict.pending, verdict.history[-1].outcome) == ("Passed", 1, "pending")
    assert toy.follow(*HANDED_OVER[:5], (7.0, "thank"), end_s=8.1).verdict == "Failed"


def test_an_act_is_observed_only_with_the_values_that_it_has(toy: Toy) -> None:
    wrong = [(4.0, "taken", {"thing": "spoon"}) if event[1] == "taken" else event for event in HANDED_OVER]
    assert violation(toy.follow(*wrong)).endswith('observed taken(thing="spoon")')


def test_the_agent_waits_as_long_as_the_run_allows(toy: Toy) -> None:
    impatient: tuple[Event, ...] = (*HANDED_OVER[:5], (7.5, "put_back"))
    assert toy.follow(*impatient, run={"patience_s": 2.5}).verdict == "Passed"
    assert violation(toy.follow(*impatient)).endswith("observed put_back")
    late = toy.follow(*HANDED_OVER[:5], (20.0, "put_back"))
    assert late.violations[0].time_s == 12.0, "5 s of patience, and 2 s for the act"


def test_an_input_just_before_a_time_out_may_come_after_it(toy: Toy) -> None:
    def run(thanked_s: float) -> str:
        return toy.follow(*HANDED_OVER[:5], (thanked_s, "thank"), (10.0, "put_back")).verdict

    assert run(9.4) == "Failed"
    assert run(9.6) == "Passed", "0.4 s before the time-out: the code under test may have missed it"
    assert toy.follow(*HANDED_OVER[:5], (9.6, "thank"), (9.8, "holding", False)).verdict == "Passed", "or not"


def test_the_agent_may_become_ready_a_little_later_than_observed(toy: Toy) -> None:
    assert toy.follow(*HANDED_OVER[:5], (9.6, "put_back")).verdict == "Passed"
    verdict = toy.follow(*HANDED_OVER[:5], (9.4, "put_back"))
    assert (verdict.verdict, verdict.violations[0].time_s) == ("Failed", 9.4)


def test_an_action_can_fail_and_the_agent_handles_it(tmp_path: Path) -> None:
    does = [each for each in TOY.actions if each.act != "let_go"]
    failing = ActionMapping("let_go", "fall(holding)", within_s=(0.0, 1.0), fails="rise(gripping)")
    toy = Toy(tmp_path, actions=(*does, failing))
    gripped: tuple[Event, ...] = (*HANDED_OVER[:6], (7.5, "gripping", False), (7.7, "gripping", True))
    assert toy.follow(*gripped, (8.0, "put_back")).verdict == "Passed"
    assert violation(toy.follow(*gripped, (8.0, "holding", False))).endswith("observed holding = False")
    assert toy.follow(*HANDED_OVER, (20.0, "gripping", False), (21.0, "gripping", True)).verdict == "Passed"


def test_a_run_is_followed_until_it_leaves_what_the_model_knows(tmp_path: Path) -> None:
    toy = Toy(tmp_path, until="rise(gripping)")
    begin: tuple[Event, ...] = ((0.0, "gripping", False), *HANDED_OVER[:5])
    verdict = toy.follow(*begin, (5.5, "gripping", True), (5.5, "holding", False), (6.0, "offer"))
    assert (verdict.verdict, verdict.passes, verdict.pending) == ("Passed", 2, 0)
    assert toy.follow(*begin, (5.5, "gripping", False), (5.5, "holding", False)).verdict == "Failed"


@pytest.mark.parametrize(
    ("gripped_s", "expected"),
    [(4.2, None), (5.1, "6 s: expected offered within 2 s of 4.0 s")],
)
def test_a_condition_that_only_takes_time_happens_when_it_becomes_true(
    tmp_path: Path, gripped_s: float, expected: str | None
) -> None:
    """Not at the next message or change of a signal, here at 7 s."""
    offered = ActionMapping("offered", "rise(historically[0:1](gripping))", within_s=(0.0, 2.0))
    toy = Toy(tmp_path, actions=(TOY.actions[0], offered, *TOY.actions[2:]))
    run = [(0.0, "gripping", False), *without("offer", HANDED_OVER), (gripped_s, "gripping", True)]
    verdict = toy.follow(*sorted(run, key=lambda event: event[0]))
    assert verdict.verdict == ("Failed" if expected else "Passed")
    assert violation(verdict).startswith(expected) if expected else verdict.passes == 3
