"""The table with a person who decides during the run: what was recorded runs again bit for bit."""

from __future__ import annotations

from functools import cache

import pytest

from pytest_hricdv.execution.case import CaseResult, RunSettings, execute
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import abstract_from, concretize
from pytest_hricdv.online.decisions import (
    ANY_INTERACTION,
    ANY_STATE,
    DISTURBANCE,
    GOAL,
    NONE,
    ChoicePoint,
    Chooser,
    Weight,
    WeightedChooser,
)
from pytest_hricdv.online.online_agent import OnlineActions, OnlineAgent
from pytest_hricdv.online.role import Role, load_role
from pytest_hricdv.testbench import Testbench
from tests.hri import bench


@cache
def table(fidelity: str = "kinematic") -> Testbench:
    """The table, simulated fast."""
    return bench.testbench().choose(fidelity=fidelity)


@cache
def role() -> Role:
    """Of the table's person."""
    bench = table()
    assert bench.people.agents
    lines = [line for line in bench.commands.commands if line not in bench.concretization.commands]
    planned = [product.planned for product in bench.cross.values() if product.planned is not None]
    return load_role(
        bench.people.agents[0], bench.model, bench.beliefs, bench.vocabulary(), lines, bench.state.name, planned
    )


def weights(goal: float, disturbance: float) -> list[Weight]:
    """The same weight for all goals, and for all disturbances."""
    goals: list[Weight] = [(ANY_STATE, ANY_INTERACTION, GOAL, each, goal) for each in role().goals]
    return [*goals, *((ANY_STATE, ANY_INTERACTION, DISTURBANCE, line, disturbance) for line in role().disturbances)]


def restless() -> list[Weight]:
    """Somebody who often has ideas, in a world where much goes wrong."""
    return weights(0.05, 0.01)


def calm() -> list[Weight]:
    """Somebody who does what the model says."""
    return weights(0.0, 0.0)


def lived(seed: int, chooser: Chooser, fidelity: str = "kinematic") -> tuple[CaseResult, OnlineAgent]:
    """A run with the person as an agent in it."""
    bench_, agent = table(fidelity), OnlineAgent(role(), chooser)
    empty = concretize(AbstractTest(f"online-{seed}", "online", "a life", (), (), seed=seed), bench_.commands)
    actions = OnlineActions(agent, bench_.commands)
    return execute(RunSettings(bench_), empty, producing=actions, watching=[agent]), agent


def replayed(result: CaseResult, fidelity: str = "kinematic") -> CaseResult:
    """The test that was recorded, run again."""
    test = concretize(abstract_from(result.test, "a life"), table(fidelity).commands)
    return execute(RunSettings(table(fidelity)), test)


class Wish:
    """Chooses what was wished, and notes in which state of the robot."""

    def __init__(self, **wishes: list[str]) -> None:
        self._wishes = {about.replace("_", " "): options for about, options in wishes.items()}
        self.states: dict[str, list[str]] = {}

    def choose(self, decision: ChoicePoint) -> str:
        """See `Chooser`."""
        if decision.about not in self._wishes:
            return NONE if NONE in decision.options else decision.options[0]
        self.states.setdefault(decision.about, []).append(decision.situation.state)
        return self._wishes[decision.about].pop(0)


def same_run(seed: int, chooser: Chooser, fidelity: str = "kinematic") -> CaseResult:
    """A run, after its recorded test was found to be the same run."""
    result, _ = lived(seed, chooser, fidelity)
    again = replayed(result, fidelity)
    assert again.record.sha256 == result.record.sha256
    assert (again.outcome, again.sim_s) == (result.outcome, result.sim_s)
    assert again.test.actions == result.test.actions
    return result


@pytest.mark.parametrize("seed", range(2))
def test_what_was_recorded_runs_again_to_the_bit(seed: int) -> None:
    assert same_run(seed, WeightedChooser(seed, calm())).test.actions[0].command == "tell leg"


@pytest.mark.parametrize("seed", range(3))
def test_what_was_recorded_of_somebody_with_ideas_runs_again_to_the_bit(seed: int) -> None:
    assert same_run(seed, WeightedChooser(seed, restless())).test.actions


def test_what_was_recorded_in_the_dynamic_world_runs_again_to_the_bit() -> None:
    one_leg = Wish(start=["leg4"], boredom=["not_bored"], leg_4=["m111l4"])
    assert same_run(3, one_leg, "dynamic").outcome.outcomes == ("released",)


def test_the_person_decides_when_it_matters_and_is_bored_where_beliefs_before_the_run_could_not_say_so() -> None:
    wish = Wish(start=["leg3"], boredom=["not_bored", "bored", "not_bored"], leg_3=["m111l3"], leg_4=["m011l4"])
    result, agent = lived(1, wish)
    assert result.outcome.outcomes == ("released", "no-human-ready", "discarded")
    leg = ["tell leg", "receivesignal"]
    assert agent.commands == [*bench.leg("111"), *leg, "bored", *bench.leg("011")]
    assert wish.states == {
        "start": [""],
        "boredom": ["Receive2"] * 3,
        "leg 3": ["Receive2"],
        "leg 4": ["Receive2"],
    }
