"""`Role`: an `InteractiveAgent` of a testbench, checked against model and vocabulary, and shared by all runs.

The closing loop makes it with `load_role`; `OnlineAgent` and `OnlinePeople` act it in each run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from pytest_hricdv.bdi.agent.agent import Agent
from pytest_hricdv.bdi.run.system import AgentTemplate
from pytest_hricdv.coupling.agent_names import AgentNames, read_agents
from pytest_hricdv.coupling.events import EventPattern, parse_heard
from pytest_hricdv.coupling.percept_mapping import CouplingError
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.model import Model
from pytest_hricdv.monitor import RequirementError, Vocabulary
from pytest_hricdv.online.declaration import InteractiveAgent, InteractiveAgentError

Planned = Callable[[Sequence[str]], Iterable[object]]
"""Maps the commands of an abstract test to the planned coordinates of each interaction (`CrossProduct.planned`)."""


@dataclass(frozen=True)
class Role:
    """An interactive agent, ready for runs; made by `load_role`.

    Args:
        space: the belief space to choose beliefs from.
        others: the names of the other agents of the model.
        percepts: an event for each of `declaration.percepts`.
        goals: the goals without parameters for which the agent has plans.
        disturbances: the lines of the testbench's disturbances.
        state: the message field with the state of the code under test, such as `state.name`; empty if there is none.
        planned: `CrossProduct.planned` of the cross products that have it; it tells in which interaction a command is.
    """

    declaration: InteractiveAgent
    model: Model
    space: BeliefSpace
    agent: AgentTemplate
    steering: AgentTemplate
    others: tuple[str, ...]
    percepts: tuple[EventPattern, ...]
    goals: tuple[str, ...]
    disturbances: tuple[str, ...] = ()
    state: str = ""
    planned: tuple[Planned, ...] = ()

    def plans_executed(self, agent: Agent) -> tuple[str, ...]:
        """The labels of the plans that the agent has executed in a run, sorted and unique."""
        labels = {plan.label for plan in self.agent.program.plans if plan.has_label}
        return tuple(sorted(labels.intersection(agent.executed)))


def load_role(
    declaration: InteractiveAgent,
    model: Model,
    space: BeliefSpace,
    vocabulary: Vocabulary,
    disturbances: Iterable[str] = (),
    state: str = "",
    planned: Iterable[Planned] = (),
) -> Role:
    """Check a declaration and make its role.

    Raises:
        InteractiveAgentError: the model has no such agent or literal, nothing binds a variable of a literal, a
            condition does not parse, or the agent is the steering agent.
    """
    name = declaration.agent
    if name == model.steering_agent:
        raise InteractiveAgentError(f"InteractiveAgent: agent {name!r} steers the others; expected one that it steers")
    try:
        (agent, steering), others = read_agents([name, model.steering_agent], model)
        names = AgentNames(agent.name, agent.program.plans)
        percepts = parse_heard(declaration.percepts, names, (*others, steering.name), vocabulary)
    except (CouplingError, RequirementError) as error:
        raise InteractiveAgentError(f"InteractiveAgent: {error}") from error
    fixed = (declaration, model, space, agent, steering, others, percepts, names.plain_goals)
    return Role(*fixed, tuple(disturbances), state, tuple(planned))
