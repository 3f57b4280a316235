"""`Oracle`: an agent of the model as an oracle, as a testbench declares it, checked and prepared for runs.

`OracleExecution` makes it with `load_oracle`, once for a testbench; each run has a `ConformanceMonitor` with it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from pytest_hricdv._base.message import nearest
from pytest_hricdv.bdi import Number
from pytest_hricdv.bdi.language.syntax import Program, Rule
from pytest_hricdv.bdi.language.terms import Key
from pytest_hricdv.bdi.run.system import AgentTemplate
from pytest_hricdv.coupling.agent_names import AgentNames, read_agents
from pytest_hricdv.coupling.events import EventPattern, parse_event, parse_heard
from pytest_hricdv.coupling.percept_mapping import CouplingError
from pytest_hricdv.declarations.model_oracle import MODEL, ModelOracle, ModelOracleError
from pytest_hricdv.generate.model import Model
from pytest_hricdv.monitor import Vocabulary


@dataclass(frozen=True)
class Oracle:
    """The oracle that follows all runs of a testbench; made by `load_oracle`. It is a `monitor.Criterion`.

    Args:
        agent: the agent that is followed.
        others: the names of the other agents of the model, which it may send messages to.
        percepts: an event for each of `declaration.percepts`.
        actions: an event for each of `declaration.actions`.
        fails: the number of an act in `actions` -> the event by which it fails.
        until: the event up to which a run is followed; None for the whole run.
    """

    declaration: ModelOracle
    agent: AgentTemplate
    others: tuple[str, ...]
    percepts: tuple[EventPattern, ...]
    actions: tuple[EventPattern, ...]
    fails: Mapping[int, EventPattern]
    until: EventPattern | None

    @property
    def id(self) -> str:
        """The id of the verdict."""
        return MODEL

    @property
    def title(self) -> str:
        """The requirement in a sentence."""
        return f"The code under test does what the agent {self.agent.name} does, in time, and nothing else"

    @property
    def source(self) -> str:
        """The file of the agent."""
        return Path(self.agent.program.file).name

    @property
    def group(self) -> str:
        """Its group in reports."""
        return "model"

    @property
    def text(self) -> str:
        """The acts, and when they have to be observed."""
        return ", ".join(f"{does.act} {window_text(*does.within_s)}" for does in self.declaration.actions)

    @cached_property
    def labels(self) -> Mapping[str, tuple[int, ...]]:
        """Label of a plan -> the acts that are its beginning."""
        acts = [
            (number, does.act[1:]) for number, does in enumerate(self.declaration.actions) if does.act.startswith("@")
        ]
        return {label: tuple(number for number, of in acts if of == label) for _, label in acts}

    @cached_property
    def literals(self) -> Mapping[Key, tuple[int, ...]]:
        """Predicate of a message or an external action -> the acts that are about it."""
        keys = [(number, event.pattern.key) for number, event in enumerate(self.actions) if event.pattern is not None]
        return {key: tuple(number for number, of in keys if of == key) for _, key in keys}


def load_oracle(declaration: ModelOracle, model: Model, vocabulary: Vocabulary, parameters: Iterable[str]) -> Oracle:
    """Check a declaration, and make it ready.

    Args:
        vocabulary: signals and messages.
        parameters: the names of the run's parameters, which limits may name.

    Raises:
        ModelOracleError: a name that the agent, the model or the run does not have, or a model that cannot be read.
        RequirementError: a condition that does not parse, located in its text.
    """
    try:
        [agent], others = read_agents([declaration.agent], model)
    except CouplingError as error:
        raise ModelOracleError(f"ModelOracle: {error}") from error
    _check_limits(declaration, agent.program, frozenset(parameters))
    names = AgentNames(agent.name, agent.program.plans)
    try:
        return Oracle(
            declaration,
            agent,
            others,
            percepts=parse_heard(declaration.percepts, names, others, vocabulary),
            actions=tuple(
                parse_event(does.owner, names.act(does.owner, does.act), does.when, vocabulary)
                for does in declaration.actions
            ),
            fails=dict(_failures(declaration, names, vocabulary)),
            until=parse_event("ModelOracle, until", None, declaration.until, vocabulary) if declaration.until else None,
        )
    except CouplingError as error:
        raise ModelOracleError(str(error)) from error


def _failures(
    declaration: ModelOracle, names: AgentNames, vocabulary: Vocabulary
) -> Iterator[tuple[int, EventPattern]]:
    for number, does in enumerate(declaration.actions):
        if does.fails:
            owner = f"{does.owner}, fails"
            yield number, parse_event(owner, names.literal_of_failure(owner, does.act), does.fails, vocabulary)


def window_text(first_s: float, last_s: float) -> str:
    """The time for an act, from when the agent is ready for it: `within 10 s`, or `after 2 to 10 s`."""
    return f"within {last_s:g} s" if first_s == 0 else f"after {first_s:g} to {last_s:g} s"


def _check_limits(declaration: ModelOracle, program: Program, parameters: frozenset[str]) -> None:
    beliefs = [belief for belief in program.beliefs if not isinstance(belief, Rule)]
    numeric = [belief.functor for belief in beliefs if len(belief.args) == 1 and isinstance(belief.args[0], Number)]
    for name, limit in declaration.limits.items():
        if name not in numeric:
            raise ModelOracleError(
                f"ModelOracle: limits: {declaration.agent} has no initial belief {name}(number){nearest(name, numeric)}"
            )
        if isinstance(limit, str):
            if limit not in parameters:
                raise ModelOracleError(
                    f"ModelOracle: limits[{name!r}]: the run has no parameter {limit!r}{nearest(limit, parameters)}"
                )
        elif isinstance(limit, bool) or not isinstance(limit, int | float):
            raise ModelOracleError(
                f"ModelOracle: limits[{name!r}] is {limit!r}; expected a number, or the name of a parameter of the run"
            )
