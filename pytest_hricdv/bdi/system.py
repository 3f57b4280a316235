"""A multi-agent system that is loaded once and run many times."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Literal, get_args

from pytest_hricdv.bdi.language.errors import BdiError
from pytest_hricdv.bdi.language.parser import parse_literal, read_program
from pytest_hricdv.bdi.language.project import Project
from pytest_hricdv.bdi.language.project_reader import read_project
from pytest_hricdv.bdi.language.syntax import Plan, Program
from pytest_hricdv.bdi.language.terms import Structure

from .actions import check_calls
from .company import Company
from .environment import Environment
from .jitter import MAX_JITTER, JitteredRun
from .library import PlanLibrary
from .memo import Fold, Memo, Runs
from .prototype import Prototype, compiled_prototypes, library_of, prototype_of
from .result import Result
from .scheduler import Run
from .traced import TracedRun

Engine = Literal["interpreter", "compiled", "memo"]
"""How agents are run; the outcome is the same."""
MAX_ROUNDS = 100_000
"""Rounds after which a run is stopped unless it is told otherwise."""


class MultiAgentSystem:
    """A multi-agent system; made by :meth:`load`.

    Example::

        system = MultiAgentSystem.load("models_bdi/table_assembly.mas2j")
        result = system.run(percepts={"meta": ["chosen(leg4)", "chosen(m111l4)"]})
        result.actions   # [("human", "tell(leg)"), ("human", "receivesignal"), ...]
    """

    def __init__(self, project: Project, prototypes: tuple[Prototype, ...], environment: Environment) -> None:
        self._project = project
        self._prototypes = prototypes
        self._names = tuple(prototype.name for prototype in prototypes)
        self._memo: Memo | None = None
        self._warnings = project.warnings
        self.environment = environment

    @classmethod
    def load(
        cls, path: str | PathLike[str], environment: Environment | None = None, engine: Engine = "compiled"
    ) -> MultiAgentSystem:
        """Read a project and its agents' sources.

        Args:
            path: a ``.mas2j`` file.
            environment: what the agents perceive and act on; without one, every action succeeds.
            engine: how agents are run, with equal results: "interpreter", the reference; "compiled", see
                :mod:`pytest_hricdv.bdi.compiled`; or "memo", the fastest when a system is run many times in the
                plain environment, see :mod:`pytest_hricdv.bdi.memo`.

        Raises:
            BdiError: a file is missing or cannot be read as what it should be; the message says where.
            ValueError: there is no such engine.
        """
        if engine not in get_args(Engine):
            raise ValueError(f"engine must be one of {', '.join(get_args(Engine))}, got {engine!r}")
        try:
            project = read_project(Path(path))
        except FileNotFoundError:
            raise BdiError(f"{path}: no such file") from None
        programs: dict[Path, tuple[Program, PlanLibrary]] = {}
        prototypes = []
        for entry in project.agents:
            if entry.source not in programs:
                program = read_program(entry.source, entry.location, project.text)
                check_calls(program)
                programs[entry.source] = program, library_of(program)
            prototypes.append(prototype_of(entry, *programs[entry.source]))
        company = Company.of({prototype.name: prototype.program for prototype in prototypes})
        for _, library in programs.values():
            library.private = company.private
        if engine != "interpreter":
            prototypes = compiled_prototypes(prototypes, company)
        system = cls(project, tuple(prototypes), environment or Environment())
        if engine == "memo":
            system._memo = Memo(system._prototypes)
        if environment is None and project.environment:
            what = f"environment {project.environment}: without a Python environment every action succeeds"
            system._warnings += (f"{path}: ignored: {what}",)
        return system

    @property
    def name(self) -> str:
        """The name of the project."""
        return self._project.name

    @property
    def warnings(self) -> tuple[str, ...]:
        """What in the project file has no effect here, each once, with its place."""
        return self._warnings

    @property
    def agents(self) -> tuple[str, ...]:
        """The names of the agents, in the order of their cycles."""
        return self._names

    @property
    def compiled(self) -> tuple[str, ...]:
        """The names of the agents of which a compiled form is used."""
        return tuple(prototype.name for prototype in self._prototypes if prototype.code is not None)

    def plan_labels(self, agent: str) -> tuple[str, ...]:
        """The labels that the author gave to an agent's plans, in source order.

        Raises:
            KeyError: there is no such agent.
        """
        return tuple(plan.label for plan in self.plans(agent) if plan.has_label)

    def program(self, agent: str) -> Program:
        """An agent's source as a syntax tree.

        Raises:
            KeyError: there is no such agent.
        """
        for prototype in self._prototypes:
            if prototype.name == agent:
                return prototype.program
        raise KeyError(agent)

    def plans(self, agent: str) -> tuple[Plan, ...]:
        """An agent's plans, in source order.

        Raises:
            KeyError: there is no such agent.
        """
        return self.program(agent).plans

    def run(
        self,
        *,
        max_rounds: int = MAX_ROUNDS,
        seed: int = 0,
        percepts: Mapping[str, Iterable[str | Structure]] | None = None,
        goal: tuple[str, str] | None = None,
        jitter: int = 0,
        trace: bool = False,
    ) -> Result:
        """Run the system from its initial state.

        Args:
            max_rounds: the number of rounds after which it is stopped.
            seed: of the random numbers that the agents draw.
            percepts: for the agents named, what they perceive at first, instead of what the environment
                lists for them; it is set in the environment and stays there.
            goal: an agent and a goal, such as ``("human", "done")``; the run ends when a plan of that agent
                for that goal has come to its end.
            jitter: by how many rounds messages and changes of percepts may be late; unless it is 0, the
                agents act in a random order in each round, too. All of it depends on the seed alone, so
                that running with several seeds exposes the races of a model.
            trace: whether to note what led to what, as the result's ``trace``.

        Raises:
            BdiError: an agent cannot go on: an action raised an exception, a rule recurses for ever.
            ValueError: an argument is out of its range, or names an agent that there is not.
        """
        if max_rounds < 0:
            raise ValueError(f"max_rounds must not be negative, got {max_rounds}")
        if not 0 <= jitter <= MAX_JITTER:
            raise ValueError(f"jitter must be from 0 to {MAX_JITTER} rounds, got {jitter}")
        environment = self.environment
        for name, literals in (percepts or {}).items():
            self._known(name)
            environment.show(name, literals)
        if goal is not None:
            self._known(goal[0])
        elif self._memo is not None and not jitter and not trace and type(environment) is Environment:
            return self._memo.run(environment, seed, max_rounds)
        awaited = None if goal is None else (goal[0], parse_literal(goal[1]))
        run = _new_run(environment, seed, awaited, jitter, trace)
        for prototype in self._prototypes:
            run.agents[prototype.name] = prototype.agent(run)
        try:
            return Result.of(run, run.go(max_rounds))
        finally:
            run.dissolve()

    def survey(
        self,
        agent: str,
        functor: str,
        atoms: Sequence[str],
        given: Mapping[str, bool],
        fold: Fold,
        max_rounds: int = MAX_ROUNDS,
        seed: int = 0,
    ) -> Runs | None:
        """Every run that there is when an agent perceives ``functor(b)`` for any set of atoms ``b``.

        Args:
            agent: the agent, which has to forward the atoms (see :mod:`pytest_hricdv.bdi.memo`).
            functor: of its percepts.
            atoms: what sets are made of.
            given: atoms that are in every set that counts, or in none.
            fold: of actions and executed plans, as in a result, those of a part of a run, what is of interest: texts in
                order, and a bit set.
            max_rounds: as in :meth:`run`.
            seed: as in :meth:`run`.

        Returns:
            What is of interest of each run, each once -> atoms that lead to it; None if the engine is not "memo", or
            runs cannot be told apart piece by piece.

        Raises:
            TooLargeError: there are too many runs.
            BdiError: an agent cannot go on.
        """
        self._known(agent)
        if self._memo is None or not atoms:
            return None
        environments = []
        for count in range(1, len(atoms) + 1):
            environments.append(Environment())
            environments[-1].show(agent, [f"{functor}({atom})" for atom in atoms[:count]])
        return self._memo.survey(environments, frozenset(atoms), given, seed, max_rounds, fold)

    def _known(self, agent: str) -> None:
        if agent not in self._names:
            raise ValueError(f"no agent {agent!r} in {self.name}; there are {', '.join(self.agents)}")


def _new_run(environment: Environment, seed: int, goal: tuple[str, Structure] | None, jitter: int, trace: bool) -> Run:
    if trace:
        return TracedRun(environment, seed, goal, jitter)
    return JitteredRun(environment, seed, goal, jitter) if jitter else Run(environment, seed, goal)
