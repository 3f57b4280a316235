"""Agents as every run begins with them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

from pytest_hricdv.bdi.language.parser import read_program
from pytest_hricdv.bdi.language.project import AgentEntry, option_beliefs, option_goals
from pytest_hricdv.bdi.language.syntax import Plan, Program, Rule
from pytest_hricdv.bdi.language.terms import SOURCE_SELF, Structure, Variable
from pytest_hricdv.bdi.logic.substitution import Bindings, free_variables, substitute_only

from .agent import Agent
from .beliefs import BeliefBase
from .company import Company
from .compiled import AgentCode, CompiledAgent, ProgramCode, compile_agent, compile_program
from .library import PlanLibrary
from .participant import Participant
from .scheduler import Run
from .traced import TracedAgent, TracedRun


@dataclass(frozen=True, slots=True)
class Prototype:
    """An agent as every run begins with it.

    Args:
        name: its name.
        program: its source.
        beliefs: its initial beliefs.
        library: its plans.
        events: what it has to react to at first.
        code: its compiled form, if it has one and the engine is to use it.
    """

    name: str
    program: Program
    beliefs: BeliefBase
    library: PlanLibrary
    events: list[tuple[str, Structure]]
    code: AgentCode | None = None

    def agent(self, run: Run) -> Participant:
        """The agent for a run."""
        if self.code is not None and run.plain:
            return CompiledAgent(self.name, run, self.code)
        kind = TracedAgent if isinstance(run, TracedRun) else Agent
        return kind(self.name, run, self.beliefs.copy(), self.library, self.events)  # type: ignore[arg-type]


@lru_cache(maxsize=1)
def _message_plans() -> tuple[Plan, ...]:
    """The plans every agent has for messages that are not acted on at once."""
    plans = read_program(Path(__file__).parent / "kqml.asl").plans
    return tuple(replace(plan, builtin=True) for plan in plans)


def library_of(program: Program) -> PlanLibrary:
    """The plans of an agent with a program: its own, then those that every agent has."""
    return PlanLibrary((*program.plans, *_message_plans()))


def prototype_of(entry: AgentEntry, program: Program, library: PlanLibrary) -> Prototype:
    """The agent of a project's entry."""
    beliefs = [*program.beliefs]
    goals = [*program.goals]
    # What the project gives comes before what the source gives: the beliefs are older, the goals earlier.
    beliefs += reversed(option_beliefs(entry))
    goals = [*option_goals(entry), *goals]
    base = BeliefBase()
    events: list[tuple[str, Structure]] = []
    # Added from the last to the first: the first is then the newest, and queries find it first.
    for belief in reversed(beliefs):
        if isinstance(belief, Rule):
            base.add_rule(belief)
            continue
        own = _own(belief)
        if base.add(own) and library.relevant("+", own.key):
            events.append(("+", own))
    events += [("+!", _own(_with_own_variables(goal))) for goal in goals]
    return Prototype(entry.name, program, base, library, events)


def _with_own_variables(goal: Structure) -> Structure:
    """The goal with variables of names that no plan uses."""
    renaming: Bindings = {variable: Variable(f"_initial_{variable}") for variable in free_variables(goal)}
    renamed = substitute_only(goal, renaming)
    return renamed if isinstance(renamed, Structure) else goal


def _own(literal: Structure) -> Structure:
    return literal if literal.has_source() else literal.with_annotations((*literal.annots, SOURCE_SELF))


def compiled_prototypes(prototypes: list[Prototype], company: Company) -> list[Prototype]:
    """The agents, with their compiled form if they have one; those with the same plans share it."""
    programs: dict[int, ProgramCode | None] = {}
    compiled = []
    for prototype in prototypes:
        plans = prototype.library
        if id(plans) not in programs:
            programs[id(plans)] = compile_program(plans, company)
        code = compile_agent(prototype.name, programs[id(plans)], prototype.beliefs, plans, prototype.events)
        compiled.append(replace(prototype, code=code))
    codes = {prototype.name: prototype.code for prototype in compiled if prototype.code is not None}
    for code in codes.values():
        code.address(codes)
    return compiled
