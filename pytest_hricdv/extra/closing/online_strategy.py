"""The strategy `online`: interactive agents decide during a run what people do, depending on what happens in the run.

`ClosureGenerator` uses `OnlineStrategy` if the testbench has `people.agents`. In a run that it proposes, `process` lets
an `OnlineRun` choose the actions. Choices are drawn at random: learning them from earlier runs gained nothing on the
table assembly.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from random import Random

from pytest_hricdv import disturbance
from pytest_hricdv.execution.case import CaseResult
from pytest_hricdv.extra.closing.strategy import Archive, Proposal
from pytest_hricdv.generate.abstract import AbstractDraft, AbstractTest
from pytest_hricdv.generate.concrete import Concretization, abstract_from
from pytest_hricdv.online.decisions import Weight, WeightedChooser
from pytest_hricdv.online.online_agent import OnlineActions, OnlineAgent
from pytest_hricdv.online.online_people import OnlinePeople
from pytest_hricdv.online.role import Role, load_role
from pytest_hricdv.run import Actions
from pytest_hricdv.testbench import Testbench

NAME = "online"


class OnlineStrategy:
    """Proposes runs in which this number of interactive agents decide what people do."""

    name = NAME

    def __init__(self, people: int) -> None:
        self._title = f"{'people who decide' if people > 1 else 'a person who decides'} during the run"

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Strategy`. Each draft is given a seed of its own, from which its choices are drawn."""
        if not archive.open:
            return []
        return [Proposal(AbstractDraft(NAME, (), (), name=self._title), NAME, is_online=True)] * count


def roles_of(testbench: Testbench) -> tuple[Role, ...]:
    """The roles of the people who decide during runs, in the order of the actors; empty if the testbench has none.

    Raises:
        InteractiveAgentError: a declaration names what the model or the run does not have.
    """
    planned = [product.planned for product in testbench.cross.values() if product.planned is not None]
    lines, model = disturbance.lines(testbench.disturbances), testbench.model
    deciding = sorted(
        testbench.people.agents, key=lambda online: model.who_acts.index(online.agent) if model.actors else 0
    )
    return tuple(
        load_role(online, model, testbench.beliefs, testbench.vocabulary(), lines, testbench.state.name, planned)
        for online in deciding
    )


class OnlineRun:
    """A run in which interactive agents decide.

    Args:
        roles: the roles of the people who decide.
        commands: the commands, with the ranges of their parameters.
        seed: the test's seed, for its parameters and choices.
        weights: the weights of choices.
    """

    def __init__(
        self, roles: Sequence[Role], commands: Concretization, seed: int, weights: Iterable[Weight] = ()
    ) -> None:
        self._roles = roles
        chooser = WeightedChooser(seed, weights)
        self.actions: Actions
        """Produces the actions of the run."""
        self.watcher: OnlineAgent | OnlinePeople
        """Listens to the run."""
        if len(roles) > 1:
            self.actions = self.watcher = OnlinePeople(roles, chooser, commands)
        else:
            self.watcher = OnlineAgent(roles[0], chooser)
            self.actions = OnlineActions(self.watcher, commands)

    def to_test(self, result: CaseResult) -> AbstractTest:
        """The test that the run became, with the plans that the agents have executed, if these count."""
        people, test, plans = self.watcher, result.test, {}
        if isinstance(people, OnlinePeople):
            test = people.as_test(test, result.sim_s)
            plans = {role.agent.name: people.plans(role.agent.name) for role in self._roles}
        else:
            plans = {self._roles[0].agent.name: people.plans}
        covered = self._roles[0].model.covered
        kept = {name: labels for name, labels in plans.items() if name in covered}
        return replace(abstract_from(test, NAME), plans=kept)
