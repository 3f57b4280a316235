"""Roles: declared interactive agents, checked against model and vocabulary, and prepared for runs."""

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
"""The plan of each interaction of an abstract test (see `CrossProduct`)."""


@dataclass(frozen=True)
class Role:
    """The state that all runs with an online agent share; made by `load_role`.

    Args:
        declaration: of the testbench.
        model: of the testbench.
        space: the beliefs that are decided.
        agent: the online agent.
        steering: the agent that steers it.
        others: the names of the other agents of the model.
        percepts: an event for each of `declaration.percepts`.
        goals: the goals without parameters that the agent has plans for.
        disturbances: the lines of the testbench's disturbances.
        state: the field that has the state of the code under test, as `state.name`; empty if there is none.
        planned: what tells the interactions of commands apart: `planned` of the cross products that have it.
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
        """The labels of the plans that the agent has executed in a run, sorted, each once."""
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
    """Check a declaration, and make it ready.

    Raises:
        InteractiveAgentError: the model has no such agent or literal, a literal has a variable that nothing is called
            after, a condition does not parse, or the agent is the one that steers.
    """
    if declaration.agent == model.steering_agent:
        raise InteractiveAgentError(
            f"InteractiveAgent: agent {declaration.agent!r} steers the others; expected one that it steers"
        )
    try:
        (agent, steering), others = read_agents([declaration.agent, model.steering_agent], model)
        names = AgentNames(agent.name, agent.program.plans)
        hears = parse_heard(declaration.percepts, names, (*others, steering.name), vocabulary)
    except (CouplingError, RequirementError) as error:
        raise InteractiveAgentError(f"InteractiveAgent: {error}") from error
    return Role(
        declaration,
        model,
        space,
        agent,
        steering,
        others,
        hears,
        names.plain_goals,
        tuple(disturbances),
        state,
        tuple(planned),
    )
