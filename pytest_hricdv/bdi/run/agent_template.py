"""Agents as every run begins with them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

from pytest_hricdv.bdi.actions.standard import StandardActions, check_calls, inspects_intentions
from pytest_hricdv.bdi.agent.agent import Agent
from pytest_hricdv.bdi.agent.plan_library import PlanLibrary
from pytest_hricdv.bdi.language.parser import read_program
from pytest_hricdv.bdi.language.project import AgentEntry, Project, beliefs_and_goals
from pytest_hricdv.bdi.language.syntax import Plan, Program, Rule
from pytest_hricdv.bdi.language.terms import SOURCE_SELF, Structure
from pytest_hricdv.bdi.logic.beliefs import BeliefBase, Content
from pytest_hricdv.bdi.logic.substitution import renamed_apart
from pytest_hricdv.bdi.run.run_state import RunState

_ACTIONS = StandardActions()


@dataclass(frozen=True, slots=True)
class AgentTemplate:
    """An agent as every run begins with it.

    Args:
        name: its name.
        program: its source.
        beliefs: its initial beliefs.
        library: its plans.
        events: what it has to react to at first.
    """

    name: str
    program: Program
    beliefs: Content
    library: PlanLibrary
    events: list[tuple[str, Structure]]

    def agent(self, run: RunState, kind: Callable[..., Agent] = Agent) -> Agent:
        """The agent for a run; ``kind`` is its class."""
        return kind(self.name, run, _ACTIONS, BeliefBase(self.beliefs), self.library, self.events)


def read_templates(project: Project) -> tuple[AgentTemplate, ...]:
    """Read the sources of a project's agents; those with the same source share their plans.

    Raises:
        BdiError: a source is missing, cannot be read, or uses an unknown internal action.
    """
    programs: dict[Path, Program] = {}
    for entry in project.agents:
        if entry.source not in programs:
            programs[entry.source] = read_program(entry.source, entry.location, project.text)
            check_calls(programs[entry.source])
    private = not any(map(inspects_intentions, programs.values()))
    libraries = {
        source: PlanLibrary((*program.plans, *_message_plans()), private) for source, program in programs.items()
    }
    return tuple(_template(entry, programs[entry.source], libraries[entry.source]) for entry in project.agents)


@lru_cache(maxsize=1)
def _message_plans() -> tuple[Plan, ...]:
    """The plans every agent has for messages that are not processed directly."""
    plans = read_program(Path(__file__).parent / "kqml.asl").plans
    return tuple(replace(plan, builtin=True) for plan in plans)


def _template(entry: AgentEntry, program: Program, library: PlanLibrary) -> AgentTemplate:
    # What the project gives comes before what the source gives: the beliefs are older, the goals earlier.
    given_beliefs, given_goals = beliefs_and_goals(entry)
    beliefs = [*program.beliefs, *reversed(given_beliefs)]
    goals = [*given_goals, *program.goals]
    base = BeliefBase()
    events: list[tuple[str, Structure]] = []
    # Added from the last to the first: the first is then the newest, and queries find it first.
    for belief in reversed(beliefs):
        if isinstance(belief, Rule):
            base.add_rule(belief)
            continue
        own = _with_source(belief)
        if base.add(own) and library.relevant("+", own.key):
            events.append(("+", own))
    events += [("+!", _with_source(_with_own_variables(goal))) for goal in goals]
    return AgentTemplate(entry.name, program, base.content(), library, events)


def _with_own_variables(goal: Structure) -> Structure:
    """The goal with variables of names that no plan uses."""
    renamed = renamed_apart(goal, "_initial_")
    return renamed if isinstance(renamed, Structure) else goal


def _with_source(literal: Structure) -> Structure:
    return literal if literal.has_source() else literal.with_annotations((*literal.annots, SOURCE_SELF))
