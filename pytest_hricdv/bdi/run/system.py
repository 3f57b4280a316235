"""`MultiAgentSystem`: a Jason project that is loaded once and run many times; `run` gives a `Result`.

Test generation (by `Memo`) and ``hricdv model`` run it. A run is a `SystemRun` with new agents (`AgentTemplate`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from os import PathLike
from pathlib import Path
from typing import NamedTuple

from pytest_hricdv.bdi.actions import StandardActions, check_calls, describe_missing, foreign_calls, inspects_intentions
from pytest_hricdv.bdi.agent.agent import Agent
from pytest_hricdv.bdi.agent.plan_library import PlanLibrary
from pytest_hricdv.bdi.language.errors import BdiError, BdiSyntaxError, Location
from pytest_hricdv.bdi.language.limits import MAX_HELD
from pytest_hricdv.bdi.language.parser import read_program
from pytest_hricdv.bdi.language.project import AgentEntry, Project, beliefs_and_goals, read_project
from pytest_hricdv.bdi.language.syntax import GOAL_STATE, Plan, Program, Rule, with_state
from pytest_hricdv.bdi.language.terms import Structure
from pytest_hricdv.bdi.logic.beliefs import BeliefBase, Content
from pytest_hricdv.bdi.logic.substitution import rename_apart
from pytest_hricdv.bdi.run.environment import Environment
from pytest_hricdv.bdi.run.jitter import JitteredRun
from pytest_hricdv.bdi.run.system_run import SystemRun
from pytest_hricdv.bdi.run.tracing import Trace, TracedAgent, TracedRun

MAX_ROUNDS = 100_000
"""Rounds after which a run is stopped by default: runs of the table example end after 177 rounds on average, 368 at
most; a run that neither ends nor repeats itself gets here in two seconds."""
_ACTIONS = StandardActions()


@dataclass(frozen=True, slots=True)
class AgentTemplate:
    """An agent in its initial state.

    Args:
        events: the sign and literal of each initial event.
    """

    name: str
    program: Program
    beliefs: Content
    library: PlanLibrary
    events: list[tuple[str, Structure]]

    def agent(self, run: SystemRun, kind: Callable[..., Agent] = Agent) -> Agent:
        """The agent for a run; ``kind`` is its class."""
        run.note_variables(self.program.last_number)
        return kind(self.name, run, _ACTIONS, BeliefBase(self.beliefs), self.library, self.events)


class Result(NamedTuple):
    """The result of a run.

    A named tuple because learning makes thousands: a frozen dataclass takes four times as long.

    Args:
        prints: what the agents printed, as ``[agent] text``, in order.
        plans: for each agent, the labels of the plans it executed, in order; labels that begin with ``_``
            are automatic, of plans without a label.
        actions: the external actions, as pairs of agent and AgentSpeak text, in order.
        rounds: the number of rounds done.
        ended: how it ended: "idle" (nothing left to do), "spin" (the agents only repeat
            themselves), "round limit", or "stopped" (by ``.stopMAS``).
        warnings: what the models' author should know, such as goals that failed unhandled.
        time_ms: virtual time at the end, in ms.
        trace: the trace, if it was requested.
        endless: the plans that had not ended when the run was ended, with their locations.
    """

    prints: list[str]
    plans: dict[str, list[str]]
    actions: list[tuple[str, str]]
    rounds: int
    ended: str
    warnings: list[str]
    time_ms: float
    trace: Trace | None = None
    endless: Sequence[str] = ()


class MultiAgentSystem:
    """A multi-agent system; made by :meth:`load`.

    Example::

        system = MultiAgentSystem.load("models_bdi/table_assembly.mas2j")
        result = system.run(percepts={"meta": ["chosen(leg4)", "chosen(m111l4)"]})
        result.actions   # [("human", "tell(leg)"), ("human", "receivesignal"), ...]
    """

    def __init__(self, project: Project, templates: tuple[AgentTemplate, ...], environment: Environment) -> None:
        self._project = project
        self._created: dict[Path, tuple[Program, PlanLibrary]] = {}
        """Sources of agents that were created in runs."""
        programs = {id(template.program): template.program for template in templates}.values()
        of_sources = dict.fromkeys(text for program in programs for text in _warnings_of(program))
        self._warnings = (*project.warnings, *of_sources)
        self.templates = templates
        """The agents in their initial states, in the order of their cycles."""
        self.environment = environment

    @classmethod
    def load(cls, path: str | PathLike[str], environment: Environment | None = None) -> MultiAgentSystem:
        """Read a project and its agents' sources.

        Args:
            path: a ``.mas2j`` file.
            environment: what the agents perceive and act on; without one, every action succeeds.

        Raises:
            BdiError: a file is missing or malformed; the message says where.
        """
        try:
            project = read_project(Path(path))
        except FileNotFoundError:
            raise BdiError(f"{path}: no such file") from None
        system = cls(project, read_templates(project), environment or Environment())
        if environment is None and project.environment:
            ignored = f"environment {project.environment}: without a Python environment every action succeeds"
            system._warnings += (f"{path}: ignored: {ignored}",)
        return system

    @property
    def name(self) -> str:
        """The name of the project."""
        return self._project.name

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about parts of the project that have no effect here or would end a run; each once, with location."""
        return self._warnings

    @property
    def agents(self) -> tuple[str, ...]:
        """The names of the agents, in the order of their cycles."""
        return tuple(template.name for template in self.templates)

    def plan_labels(self, agent: str) -> tuple[str, ...]:
        """The labels that the author gave to an agent's plans, in source order.

        Raises:
            KeyError: the agent is unknown.
        """
        return tuple(plan.label for plan in self.plans(agent) if plan.has_label)

    def program(self, agent: str) -> Program:
        """An agent's source as a syntax tree. Raises KeyError for an unknown agent."""
        for template in self.templates:
            if template.name == agent:
                return template.program
        raise KeyError(agent)

    def plans(self, agent: str) -> tuple[Plan, ...]:
        """An agent's plans, in source order. Raises KeyError for an unknown agent."""
        return self.program(agent).plans

    def run(
        self,
        *,
        max_rounds: int = MAX_ROUNDS,
        seed: int = 0,
        percepts: Mapping[str, Iterable[str | Structure]] | None = None,
        jitter: int = 0,
        trace: bool = False,
    ) -> Result:
        """Run the system from its initial state.

        Args:
            max_rounds: number of rounds after which the run is stopped.
            seed: seed of the random numbers that the agents draw.
            percepts: agent -> what it perceives at first, instead of what the environment lists for it; the
                environment keeps them for later runs.
            jitter: maximum delay of messages and changes of percepts, in rounds; unless 0, the agents also act in
                a random order in each round. Both depend on the seed alone, so that running with several seeds
                exposes the races of a model.
            trace: whether to record what led to what, as the result's ``trace``.

        Raises:
            BdiError: an agent cannot continue, e.g. an action raised an exception or a rule recurses for ever.
            ValueError: an argument is out of range, or an agent is unknown.
        """
        if max_rounds < 0:
            raise ValueError(f"max_rounds must not be negative, got {max_rounds}")
        if jitter < 0:
            raise ValueError(f"jitter must not be negative, got {jitter}")
        self.show(percepts)
        run = _new_run(self.environment, seed, jitter, trace)
        for template in self.templates:
            run.agents[template.name] = template.agent(run, TracedAgent if trace else Agent)
        run.new_agent = self.new_agent
        try:
            return _result(run, run.go(max_rounds))
        finally:
            run.close()

    def new_agent(self, run: SystemRun, name: str, source: str, place: Location) -> Agent:
        """An agent for a run, with a source that lies next to the project file or the sources of its agents.

        Args:
            place: location of the action that creates it, for the error.

        Raises:
            BdiError: the source is missing, cannot be read, or uses an unknown internal action.
        """
        entries = self._project.agents
        folders = [Path(entries[0].location.file).parent, *(entry.source.parent for entry in entries)]
        candidates = [folder / source for folder in folders]
        path = next((candidate for candidate in candidates if candidate.exists()), candidates[0])
        if not path.exists():
            raise BdiError(f"{place}: no such file: {path}; the source of a new agent lies next to the project file")
        if path not in self._created:  # an agent may create thousands
            program = read_program(path)
            check_calls(program)
            self._created[path] = program, PlanLibrary((*program.plans, *_message_plans()))
        template = _template(AgentEntry(name, path, place), *self._created[path])
        return template.agent(run, TracedAgent if isinstance(run, TracedRun) else Agent)

    def show(self, percepts: Mapping[str, Iterable[str | Structure]] | None) -> None:
        """Let agents perceive these literals, instead of what the environment lists for them.

        Raises:
            ValueError: an agent is unknown.
            BdiError: a string is not a literal without variables.
        """
        for name, literals in (percepts or {}).items():
            self.environment.show(self.check_agent(name), literals)

    def check_agent(self, agent: str) -> str:
        """The name of an agent. Raises ValueError for an unknown one."""
        if agent not in self.agents:
            raise ValueError(f"no agent {agent!r} in {self.name}; there are {', '.join(self.agents)}")
        return agent


def _warnings_of(program: Program) -> list[str]:
    """Warnings for the author of a source: how it was read, and what ends a run; each action once."""
    calls = {call.name: call for call in reversed(foreign_calls(program))}
    ends = [f"{describe_missing(call)}; a run ends where it is called" for call in reversed(calls.values())]
    return [*program.warnings, *ends]


def _new_run(environment: Environment, seed: int, jitter: int, trace: bool) -> SystemRun:
    if trace:
        return TracedRun(environment, seed, jitter)
    return JitteredRun(environment, seed, jitter) if jitter else SystemRun(environment, seed)


def _result(run: SystemRun, ended: str) -> Result:
    plans = {name: agent.executed for name, agent in {**run.killed, **run.agents}.items()}
    trace = Trace(tuple(run.steps)) if isinstance(run, TracedRun) else None
    return Result(run.prints, plans, run.actions, run.rounds, ended, run.warnings, run.time_ms, trace, run.endless)


def read_templates(project: Project) -> tuple[AgentTemplate, ...]:
    """Read the sources of a project's agents; agents with the same source share their plans.

    Raises:
        BdiError: a source is missing, cannot be read, or uses an unknown internal action.
    """
    programs: dict[Path, Program] = {}
    beliefs = 0
    for entry in project.agents:
        if entry.source not in programs:
            programs[entry.source] = read_program(entry.source, entry.location, project.text)
            check_calls(programs[entry.source])
        beliefs += len(programs[entry.source].beliefs) + len(beliefs_and_goals(entry)[0])
        if beliefs > MAX_HELD:
            message = f"more than {MAX_HELD:,} beliefs of all agents together"
            raise BdiSyntaxError.at(message, entry.location, project.text)
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
    # The project's beliefs and goals come before those of the source: they are older.
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
        own = belief.with_own_source()
        if base.add(own) and library.relevant("+", own.key):
            events.append(("+", own))
    initial = [_with_own_variables(goal).with_own_source() for goal in goals]
    started = [(GOAL_STATE, with_state(goal, "started")) for goal in reversed(initial)]
    followed = [event for event in started if library.relevant(GOAL_STATE, event[1].key)]
    events = [*followed, *events, *(("+!", goal) for goal in initial)]
    return AgentTemplate(entry.name, program, base.content(), library, events)


def _with_own_variables(goal: Structure) -> Structure:
    """The goal with variables of names that no plan uses."""
    renamed = rename_apart(goal, "_initial_")
    return renamed if isinstance(renamed, Structure) else goal
