"""Lanes of a run: nodes take the actions of their actor; who comes first, who waits, what is refused."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from pytest_hricdv.disturbance import Disturbance
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest
from pytest_hricdv.run import Run, TestbenchError
from tests.test_run import make_run

ACTORS = ("nurse", "child")


def lanes(
    *lines: str,
    turns: Mapping[int, float] = {},
    after: Mapping[int, tuple[int, ...]] = {},
    wait_s: float = 100.0,
) -> Run:
    """A run of a test with these lines; the actions of people take 2 s."""
    actions = [ConcreteAction(line, {"turn": turns.get(number, 0.5)}) for number, line in enumerate(lines, 1)]
    run = make_run(ConcreteTest("t", "s", 1, tuple(actions), {"turn_wait_s": wait_s}, after))
    run.actors = ACTORS
    return run


def enact(run: Run, takes_s: Mapping[str, float] = {}) -> list[str]:
    """Let both enact their lanes; what began, and when."""

    def person(actor: str) -> None:
        for action in run.actions(actor):
            assert "turn" not in action.parameters
            assert ":" not in action.command
            run.kernel.sleep(takes_s.get(actor, 2.0))

    for actor in ACTORS:
        run.kernel.spawn(actor, lambda actor=actor: person(actor))  # type: ignore[misc]
    run.go(60.0)
    return [f"{time_s:g} {action.command}" for time_s, action in zip(run.action_times_s, run.taken, strict=True)]


def test_lanes_go_on_side_by_side_in_the_order_of_their_turns() -> None:
    run = lanes("nurse: a", "nurse: b", "child: x", turns={1: 0.5, 2: 0.9, 3: 0.7})
    assert enact(run) == ["0 nurse: a", "0 child: x", "2 nurse: b"]
    assert run.begun == [0, 2, 1]
    assert run.enacted == run.test
    run = lanes("nurse: a", "nurse: b", "child: x", turns={1: 0.5, 2: 0.6, 3: 0.7})
    assert enact(run) == ["0 nurse: a", "2 nurse: b", "2 child: x"]


def test_what_was_caused_waits_until_its_cause_is_done_however_long_that_takes() -> None:
    run = lanes("nurse: a", "child: x", after={2: (1,)}, wait_s=0.0)
    assert enact(run, {"nurse": 30.0}) == ["0 nurse: a", "30 child: x"]


def test_nobody_waits_for_an_actor_who_has_left() -> None:
    run = lanes("nurse: a", "nurse: b", "child: x", turns={3: 0.7})

    def nurse() -> None:
        for _ in run.actions("nurse"):
            run.kernel.sleep(1.0)
            return

    def child() -> None:
        for _ in run.actions("child"):
            run.kernel.sleep(2.0)

    run.kernel.spawn("nurse", nurse)
    run.kernel.spawn("child", child)
    run.go(60.0)
    assert run.action_times_s == [0.0, 1.0]
    assert run.begun == [0, 2]


def test_a_disturbance_comes_with_the_action_below_it_or_at_the_end() -> None:
    applied: list[float] = []
    run = lanes("disturb slip", "nurse: a", "child: x", "disturb slip", "nurse: b", "disturb slip")
    run.disturbances = {"slip": Disturbance({}, lambda world, given: world.append(run.kernel.now_s))}
    run.set_disturbance_target(applied)
    enact(run)
    assert applied == [0.0, 2.0, 4.0]
    assert run.begun == [0, 1, 2, 3, 4, 5]


@pytest.mark.parametrize(
    ("actor", "complaint"),
    [
        ("", "run.actions(): expected the name of an actor of the model; known: nurse, child"),
        ("chld", "run.actions('chld'): expected the name of an actor of the model; nearest: child"),
    ],
)
def test_whose_actions_is_said(actor: str, complaint: str) -> None:
    with pytest.raises(TestbenchError) as refused:
        lanes("nurse: a").actions(actor)
    assert str(refused.value) == complaint


def test_the_actions_of_an_actor_are_taken_by_one_node() -> None:
    run = lanes("nurse: a")
    run.actions("nurse")
    with pytest.raises(TestbenchError, match="a node takes its actions already; expected one node"):
        run.actions("nurse")


def test_an_actor_whose_actions_nobody_takes_is_told() -> None:
    run = lanes("nurse: a", "child: x")
    assert run.idle_actors() == ("nurse", "child")
    run.actions("child")
    assert run.idle_actors() == ("nurse",)


def test_a_world_that_has_the_whole_test_reports_what_begins_in_its_own_order() -> None:
    run = lanes("nurse: a", "child: x")
    for number in (1, 1, 0):
        run.report_action(number)
    assert run.begun == [1, 0]
    assert run.idle_actors() == ()
