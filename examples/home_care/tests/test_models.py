"""The BDI models: what their beliefs lead to, and that every plan has some that lead to it."""

from __future__ import annotations

from functools import cache

import pytest
from people.beliefs import BELIEFS, MODEL
from people.ranges import COMMANDS

from pytest_hricdv.bdi import MultiAgentSystem
from pytest_hricdv.bdi.__main__ import main
from pytest_hricdv.bdi.language.parser import read_program

SETS = (
    "first_fridge",
    "first_sink second_sink third_sink",
    "first_feed second_feed third_feed dog_follows",
    "first_clean second_fridge third_clean",
    "first_unknown second_unknown third_unknown",
    "first_unknown says_chase leaves",
    "first_unknown says_opendoor second_feed",
    "first_unknown says_recharge third_unknown",
    "first_clean second_unknown third_feed impatient",
    "first_fridge second_feed third_clean insistent leaves",
    "first_feed second_clean fickle",
    "first_clean second_feed third_sink meddling",
    "first_clean second_fridge obstinate",
    "first_fridge second_unknown obstinate",
    "first_unknown second_feed meddling",
    "first_sink second_unknown third_fridge restless",
    "first_fridge second_clean third_fridge lingering",
)
"""Belief sets that lead to every plan between them."""


@cache
def system() -> MultiAgentSystem:
    return MultiAgentSystem.load(MODEL.path)


@cache
def ran(beliefs: str) -> tuple[tuple[tuple[str, str], ...], dict[str, set[str]]]:
    """Who did what, and the plans by agent."""
    result = system().run(percepts={"meta": [f"chosen({belief})" for belief in beliefs.split()]})
    assert result.ended == "idle"
    assert not result.warnings
    return tuple(result.actions), {agent: set(plans) for agent, plans in result.plans.items()}


def acts(agent: str, beliefs: str) -> list[str]:
    return [action for actor, action in ran(beliefs)[0] if actor == agent]


def test_lint_finds_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["lint", str(MODEL.path)]) == 0, capsys.readouterr().out


@pytest.mark.parametrize("agent", ["person", "robot", "sensors", "dog"])
def test_every_plan_of_an_agent_is_executed_with_some_beliefs(agent: str) -> None:
    program = read_program(MODEL.path.with_name(f"{agent}.asl"))
    labels = {plan.label for plan in program.plans if plan.has_label}
    assert labels - set().union(*(ran(beliefs)[1].get(agent, set()) for beliefs in SETS)) == set()


def test_an_order_can_come_as_often_as_one_likes_and_in_any_sequence() -> None:
    assert acts("person", "first_sink second_sink third_sink") == ["sink", "sink", "sink"]
    assert acts("person", "first_clean second_fridge third_clean") == ["clean", "fridge", "clean"]


@pytest.mark.parametrize("order", ["chase", "opendoor", "recharge"])
def test_what_the_robot_cannot_do_is_asked_and_refused(order: str) -> None:
    beliefs = f"first_unknown says_{order}"
    assert acts("person", beliefs) == [order]
    assert f"refuse({order})" in acts("robot", beliefs)


def test_an_impatient_person_has_several_orders_wait() -> None:
    done = acts("robot", "first_fridge second_feed third_clean impatient")
    assert [action for action in done if action.startswith("accept")] == [
        "accept(fridge)",
        "accept(feed)",
        "accept(clean)",
    ]
    assert done.index("accept(clean)") < done.index("complete(fridge)")
    assert "complete(clean)" in done


def test_an_order_that_no_longer_fits_into_the_queue_is_refused() -> None:
    assert "full" in ran("first_fridge second_feed third_clean insistent leaves")[1]["robot"]


def test_the_robot_becomes_idle_before_the_first_order_and_after_the_last_one() -> None:
    assert acts("robot", "first_unknown second_fridge lingering")[:4] == [
        'enter("Ready")',
        "refuse(whatever)",
        "report_idle",
        'enter("Recharge")',
    ]
    assert acts("robot", "first_fridge")[-4:] == ["report_idle", 'enter("Recharge")', "dock", 'enter("Ready")']


def test_a_dog_in_the_way_is_called_and_the_order_goes_on() -> None:
    beliefs = "first_feed dog_follows"
    assert acts("person", beliefs) == ["feed", "call_dog"]
    assert "complete(feed)" in acts("robot", beliefs)


def test_who_stays_in_the_way_hears_that_the_robot_gives_up_and_asks_again() -> None:
    beliefs = "first_fridge obstinate"
    assert acts("person", beliefs) == ["ask(fridge)", "walk(fridge)", "wait", "sit", "ask(fridge)"]
    assert [act for act in acts("robot", beliefs) if "fridge" in act] == [
        "accept(fridge)",
        "refuse(fridge)",
        "accept(fridge)",
        "complete(fridge)",
    ]


def test_what_the_person_does_are_commands_with_ranges() -> None:
    from pytest_hricdv.generate.abstract import command_from_action

    commands = {command_from_action(action) for beliefs in SETS for action in acts("person", beliefs)}
    assert commands <= set(COMMANDS)
    assert {"fridge", "ask feed", "walk tv", "sit", "call_dog", "rest", "wait", "ended"} <= commands


def test_each_belief_of_the_space_is_in_a_set_or_means_nothing() -> None:
    used = {belief for beliefs in SETS for belief in beliefs.split()}
    assert set(BELIEFS.beliefs) - used == set(BELIEFS.default_beliefs)
