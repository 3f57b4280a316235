"""A run in which the person decides what to do, by weights; and the test that it becomes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from pytest_hricdv import disturbance
from pytest_hricdv.execution.case import CaseResult
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import Concretization, abstract_from
from pytest_hricdv.online.chooser import Weight, WeightedChooser
from pytest_hricdv.online.online_actions import OnlineActions
from pytest_hricdv.online.online_agent import OnlineAgent
from pytest_hricdv.online.role import Role, load_role
from pytest_hricdv.testbench import Testbench

TARGET = "online"


def role_of(testbench: Testbench) -> Role | None:
    """The role of the person; None where the testbench declares none.

    Raises:
        OnlineError: the declaration names what the model or the run does not have.
    """
    if testbench.online is None:
        return None
    planned = [product.planned for product in testbench.cross.values() if product.planned is not None]
    return load_role(
        testbench.online,
        testbench.model,
        testbench.beliefs,
        testbench.vocabulary(),
        disturbance.lines(testbench.disturbances),
        testbench.state,
        planned,
    )


class OnlineRun:
    """One such run.

    Args:
        role: of the person.
        commands: with the ranges of their parameters.
        seed: of the test: of its parameters, and of what is chosen.
        weights: of choices.
    """

    def __init__(self, role: Role, commands: Concretization, seed: int, weights: Iterable[Weight] = ()) -> None:
        self._role = role
        self.agent = OnlineAgent(role, WeightedChooser(seed, weights))
        self.actions = OnlineActions(self.agent, commands)

    def recorded(self, result: CaseResult) -> AbstractTest:
        """The test that the run became, with the plans that the agent has executed, if these count."""
        test, name = abstract_from(result.test, TARGET), self._role.agent.name
        return replace(test, plans={name: self.agent.plans} if name in self._role.model.covered else {})
