"""The agent of the person in a run: it decides late, hears between its actions, and gives one command after another."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.coupling.percept_mapping import PerceptMapping
from pytest_hricdv.online.decisions import ACT, GOAL, NONE, Choice, Situation
from pytest_hricdv.online.declaration import InteractiveAgent, InteractiveAgentError
from tests.online.toy import Life, Wish, role


def abouts(chooser: Wish) -> list[str]:
    """What was asked, but for goals."""
    return [decision.about for decision in chooser.asked if decision.about != GOAL]


def test_it_does_what_its_plans_say_and_then_waits(tmp_path: Path) -> None:
    life = Life(role(tmp_path), Wish(taste=["likes_cold"], voice=["quiet"]))
    assert life.commands() == ["press"]
    life.said("offer", size="small")
    assert life.commands() == ["cool", "drink small", "nod"]
    assert life.agent.plans == ("cold", "thirsty")


def test_beliefs_are_decided_when_they_are_looked_up_and_not_before(tmp_path: Path) -> None:
    chooser = Wish(start=["curious"], taste=["likes_hot"], voice=["quiet"])
    life = Life(role(tmp_path), chooser)
    assert (life.commands(), abouts(chooser)) == (["wave"], ["start"])
    life.said("state", name="Pouring")
    life.said("offer", size="small")
    assert life.commands(1) == ["drink hot"]
    assert abouts(chooser) == ["start", "taste"]
    taste = chooser.asked[-2]
    assert taste.options == (NONE, "likes_hot", "likes_cold")
    assert taste.situation == Situation(1.0, "Pouring", 1, ("wave",))
    assert life.commands() == ["nod"]
    assert abouts(chooser) == ["start", "taste", "voice"]
    assert life.agent.choices == [
        Choice(0, "", 0, "start", "curious"),
        Choice(1, "Pouring", 1, "taste", "likes_hot"),
        Choice(2, "Pouring", 1, "voice", "quiet"),
    ]


def test_a_group_without_a_belief_is_open_again_and_one_with_a_belief_is_not(tmp_path: Path) -> None:
    chooser = Wish(taste=[NONE, "likes_hot"], voice=["quiet", "loud"])
    life = Life(role(tmp_path), chooser)
    found = life.commands()
    for _ in range(3):
        life.said("offer", size="small")
        found += life.commands()
    assert found == ["press", "refuse", "drink hot", "nod", "drink hot", "shout"]
    assert abouts(chooser) == ["start", "taste", "taste", "voice", "voice"]


def test_it_hears_what_happened_meanwhile_only_after_its_command(tmp_path: Path) -> None:
    life = Life(role(tmp_path, "@a +!fetch <- press; +busy; wave. +alarm : busy <- leave. +alarm <- stay."), Wish())
    life.agent.signal(0.0, "smoke", False)
    assert life.agent.next_command(1.0) == "press"
    life.agent.signal(1.5, "smoke", True)
    assert life.agent.next_command(3.0) == "wave"
    assert life.agent.next_command(4.0) == "leave"


def test_what_was_heard_is_believed_until_its_end_is_heard_as_well(tmp_path: Path) -> None:
    person = (
        "@a +!fetch <- press. +alarm <- leave. "
        "+clear <- -clear[source(percept)]; -alarm[source(percept)]; nod. +cup(_)."
    )
    hears = (PerceptMapping("alarm", "rise(smoke)"), PerceptMapping("clear", "fall(smoke)"))
    for heard, expected in (
        (hears, ["press", "leave", "nod", "leave"]),
        (hears[:1], ["press", "leave"]),  # it has not heard that the smoke has gone
    ):
        life = Life(role(tmp_path, person, InteractiveAgent("person", heard)), Wish())
        done = life.commands()
        for smoke in (True, False, True):
            life.agent.signal(life.time_s, "smoke", False)
            life.agent.signal(life.time_s + 0.1, "smoke", smoke)
            life.time_s += 1.0
            done += life.commands()
        assert done == expected


def test_a_goal_can_be_posted_where_the_agent_decides_what_to_do(tmp_path: Path) -> None:
    chooser = Wish(goal=["thank", NONE], voice=["loud"], act=["shout"])
    life = Life(role(tmp_path), chooser)
    assert life.commands() == ["shout", "press"]
    goal, act = chooser.asked[1], chooser.asked[3]
    assert (goal.about, goal.options) == (GOAL, (NONE, "fetch", "thank"))
    assert (act.about, act.options) == (ACT, ("press", "shout"))


def test_after_waiting_it_does_only_what_follows_from_what_it_heard(tmp_path: Path) -> None:
    chooser = Wish(goal=[NONE, NONE, "thank"], voice=["quiet"])
    life = Life(role(tmp_path), chooser)
    assert life.commands() == ["press"]
    assert life.agent.next_command(5.0, waited=True) is None
    life.said("offer", size="small")
    assert life.agent.next_command(6.0, waited=True) == "refuse"
    assert life.agent.next_command(7.0) == "nod"


def test_waiting_for_time_takes_none_of_the_run_and_only_after_nothing_else_can_come(tmp_path: Path) -> None:
    person = "@a +!fetch <- press; .wait(5000); wave; .wait(alarm, 3000); sit. -!fetch <- leave."
    life = Life(role(tmp_path, person), Wish())
    assert life.commands() == ["press"]
    assert life.agent.let_time_pass() == "wave"
    assert life.agent.next_command(2.0) is None
    assert life.agent.let_time_pass() == "leave"
    assert (life.agent.next_command(3.0), life.agent.let_time_pass()) == (None, None)


def test_what_it_waits_for_comes_before_the_end_of_the_wait(tmp_path: Path) -> None:
    person = '@a +!fetch <- press; wave; .wait("+cup(_)", 3000); drink. -!fetch <- leave.'
    life = Life(role(tmp_path, person), Wish())
    assert life.commands(2) == ["press", "wave"]
    life.said("offer", size="small")
    assert life.agent.next_command(10.0) in ("drink", "leave")


@pytest.mark.parametrize(
    ("declaration", "told"),
    [
        (InteractiveAgent("persn"), "InteractiveAgent: no agent 'persn' in * nearest: person"),
        (InteractiveAgent("meta"), "InteractiveAgent: agent 'meta' steers the others; expected one that it steers"),
        (
            InteractiveAgent("person", (PerceptMapping("cupp(Size)", "on(offer)"),)),
            "InteractiveAgent: PerceptMapping('cupp(Size)'): person has no belief cupp; nearest: cup",
        ),
        (
            InteractiveAgent("person", (PerceptMapping("cup", "on(offer)"),)),
            "InteractiveAgent: PerceptMapping('cup'): person has no belief cup with 0 arguments; it has 1",
        ),
        (
            InteractiveAgent("person", (PerceptMapping("cup(", "on(offer)"),)),
            "InteractiveAgent: PerceptMapping('cup('): *",
        ),
        (
            InteractiveAgent("person", (PerceptMapping("cup(Sise)", "on(offer)"),)),
            "InteractiveAgent: PerceptMapping('cup(Sise)'): Sise is neither a field of its message nor *nearest: size",
        ),
        (
            InteractiveAgent("person", (PerceptMapping("alarm", "on(offer)", source="robt"),)),
            "InteractiveAgent: PerceptMapping('alarm'): no agent 'robt'; nearest: robot",
        ),
        (
            InteractiveAgent("person", (PerceptMapping("alarm", "on(ofer)"),)),
            "InteractiveAgent: PerceptMapping('alarm'), column 4: unknown topic 'ofer'; nearest: offer",
        ),
        (
            InteractiveAgent("person", (PerceptMapping("alarm", "smoke"),)),
            "InteractiveAgent: PerceptMapping('alarm'), column 1: expected an event*",
        ),
    ],
)
def test_names_and_conditions_that_are_none_are_refused(
    tmp_path: Path, declaration: InteractiveAgent, told: str
) -> None:
    with pytest.raises(InteractiveAgentError) as error:
        role(tmp_path, declaration=declaration)
    begin, _, end = told.partition("*")
    assert str(error.value).startswith(begin.rstrip()), str(error.value)
    assert end.strip() in str(error.value), str(error.value)


def test_an_agent_that_cannot_go_on_is_an_error_with_its_time(tmp_path: Path) -> None:
    life = Life(role(tmp_path, "@a +!fetch <- press; !spin. +!spin <- .print(x); !spin."), Wish())
    assert life.commands(1) == ["press"]
    with pytest.raises(InteractiveAgentError, match=r"InteractiveAgent: person at 1\.000 s: .* does not come to rest"):
        life.commands()


NOSE = """
+!fetch : thirsty | curious <- press.
+cup(_).
+alarm <- leave.
+clear <- -clear[source(percept)]; !forget.
+!forget : likes_hot <- -alarm[source(percept)]; forget.
+!forget : likes_cold | loud <- keep.
"""
"""Leaves when there is smoke; forgets that there was some, or does not."""


@pytest.mark.parametrize(
    ("taste", "again"),
    [pytest.param("likes_hot", ["leave"], id="taken back"), pytest.param("likes_cold", [], id="kept")],
)
def test_what_is_heard_is_believed_until_a_plan_takes_it_back(tmp_path: Path, taste: str, again: list[str]) -> None:
    hears = (PerceptMapping("alarm", "rise(smoke)"), PerceptMapping("clear", "fall(smoke)"))
    life = Life(role(tmp_path, NOSE, InteractiveAgent("person", hears)), Wish(taste=[taste]))
    done = []
    for smoke in (False, True, False, True):
        life.agent.signal(life.time_s, "smoke", smoke)
        life.time_s += 1.0
        done.append(life.commands())
    assert done == [["press"], ["leave"], ["forget" if again else "keep"], again]
