"""A declaration of conformance, checked against the model and the vocabulary, and made ready for following runs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from pytest_hricdv.bdi import BdiError, Number, Structure, Term, Variable
from pytest_hricdv.bdi.language.project import read_project
from pytest_hricdv.bdi.language.syntax import Program, Rule
from pytest_hricdv.bdi.language.syntax_tree import variables_of
from pytest_hricdv.bdi.language.terms import Key
from pytest_hricdv.bdi.logic.substitution import substitute_only
from pytest_hricdv.bdi.run.system import AgentTemplate, read_templates
from pytest_hricdv.conformance.agent_names import AgentNames, owner_of
from pytest_hricdv.conformance.declaration import MODEL, PERCEPT, Conformance, ConformanceError
from pytest_hricdv.conformance.terms import term_of
from pytest_hricdv.generate.model import Model
from pytest_hricdv.monitor import FormulaSource, PastFormula, Value, Vocabulary, parse_condition
from pytest_hricdv.monitor.analysis import is_instantaneous, topics_of
from pytest_hricdv.suggestion import nearest

Bindings = dict[Variable, Term]


@dataclass(frozen=True)
class Event:
    """A pattern of a literal, and the condition that fills in its variables.

    Args:
        owner: names the correspondence in errors.
        pattern: the literal; None for a plan's label.
        condition: when it happens.
        sources: variable -> the signal or `topic.field` that it stands for.
    """

    owner: str
    pattern: Structure | None
    condition: PastFormula
    sources: Mapping[Variable, str]

    def bindings(self, values: Mapping[str, Value]) -> Bindings:
        """The values of the variables, by the last values of signals and fields.

        Raises:
            ConformanceError: a signal has no value yet.
        """
        if unknown := [name for name in self.sources.values() if name not in values]:
            raise ConformanceError(f"{self.owner}: {unknown[0]} has no value yet; signals need one from the start")
        return {variable: term_of(values[name]) for variable, name in self.sources.items()}

    def literal(self, bindings: Bindings) -> Structure:
        """The pattern with its variables replaced."""
        literal = None if self.pattern is None else substitute_only(self.pattern, bindings)
        assert isinstance(literal, Structure), self.owner
        return literal


@dataclass(frozen=True)
class Oracle:
    """What all runs of a testbench are followed with; made by `load_oracle`. It is a `monitor.Criterion`.

    Args:
        declaration: of the testbench.
        agent: the agent that is followed.
        others: the names of the other agents of the model, which it may send messages to.
        hears: an event for each of `declaration.hears`.
        does: an event for each of `declaration.does`.
        fails: the number of an act in `does` -> the event by which it fails.
    """

    declaration: Conformance
    agent: AgentTemplate
    others: tuple[str, ...]
    hears: tuple[Event, ...]
    does: tuple[Event, ...]
    fails: Mapping[int, Event]

    @property
    def id(self) -> str:
        """Of the verdict."""
        return MODEL

    @property
    def title(self) -> str:
        """What is required, in a sentence."""
        return f"The code under test does what the agent {self.agent.name} does, in time, and nothing else"

    @property
    def source(self) -> str:
        """The file of the agent."""
        return Path(self.agent.program.file).name

    @property
    def group(self) -> str:
        """What reports put it under."""
        return "model"

    @property
    def text(self) -> str:
        """The acts, and when they have to be observed."""
        return ", ".join(f"{does.act} {window_text(*does.within_s)}" for does in self.declaration.does)

    @cached_property
    def labels(self) -> Mapping[str, tuple[int, ...]]:
        """Label of a plan -> the acts that are its beginning."""
        acts = [(number, each.act[1:]) for number, each in enumerate(self.declaration.does) if each.act.startswith("@")]
        return {label: tuple(number for number, of in acts if of == label) for _, label in acts}

    @cached_property
    def literals(self) -> Mapping[Key, tuple[int, ...]]:
        """Predicate of a message or an external action -> the acts that are about it."""
        keys = [(number, event.pattern.key) for number, event in enumerate(self.does) if event.pattern is not None]
        return {key: tuple(number for number, of in keys if of == key) for _, key in keys}


def load_oracle(declaration: Conformance, model: Model, vocabulary: Vocabulary, parameters: Iterable[str]) -> Oracle:
    """Check a declaration, and make it ready.

    Args:
        declaration: of the testbench.
        model: of the testbench.
        vocabulary: signals and messages.
        parameters: the names of the run's parameters, which limits may name.

    Raises:
        ConformanceError: a name that the agent, the model or the run does not have, or a model that cannot be read.
        RequirementError: a condition that does not parse, located in its text.
    """
    agent, others = _read_agent(declaration.agent, model)
    for hears in declaration.hears:
        if hears.source != PERCEPT and hears.source not in others:
            raise ConformanceError(f"{owner_of(hears)}: no agent {hears.source!r}{nearest(hears.source, others)}")
    names = AgentNames(agent.name, agent.program.plans)
    _check_limits(declaration, agent.program, frozenset(parameters))
    fails = {number: does for number, does in enumerate(declaration.does) if does.fails}
    return Oracle(
        declaration,
        agent,
        others,
        hears=tuple(_event(owner_of(each), names.heard(each), each.when, vocabulary) for each in declaration.hears),
        does=tuple(_event(owner_of(each), names.act(each), each.when, vocabulary) for each in declaration.does),
        fails={
            number: _event(f"{owner_of(each)}, fails", names.failing(each), each.fails, vocabulary)
            for number, each in fails.items()
        },
    )


def _read_agent(name: str, model: Model) -> tuple[AgentTemplate, tuple[str, ...]]:
    """The agent of that name, and the names of all others. Only its own source is read: others can be large."""
    try:
        project = read_project(model.path)
        names = [entry.name for entry in project.agents]
        if name not in names:
            raise ConformanceError(f"Conformance: no agent {name!r} in {model.path}{nearest(name, names)}")
        entry = project.agents[names.index(name)]
        [agent] = read_templates(replace(project, agents=(entry,)))
    except (BdiError, OSError) as error:
        raise ConformanceError(f"Conformance: BDI model {model.path}: {error}") from error
    return agent, tuple(other for other in names if other != name)


def window_text(first_s: float, last_s: float) -> str:
    """The time for an act, from when the agent is ready for it: `within 10 s`, or `after 2 to 10 s`."""
    return f"within {last_s:g} s" if first_s == 0 else f"after {first_s:g} to {last_s:g} s"


def _event(owner: str, pattern: Structure | None, when: str, vocabulary: Vocabulary) -> Event:
    source = FormulaSource(when, owner=owner)
    condition = parse_condition(when, vocabulary, source)
    if not is_instantaneous(condition):
        advice = "it holds for a time; name the event: on(topic) & ..., rise(...), or fall(...)"
        raise source.error(0, len(when), "expected an event", advice)
    return Event(owner, pattern, condition, _sources(owner, pattern, condition, vocabulary))


def _sources(
    owner: str, pattern: Structure | None, condition: PastFormula, vocabulary: Vocabulary
) -> dict[Variable, str]:
    fields = {
        field: f"{topic}.{field}" for topic in sorted(topics_of([condition])) for field in vocabulary.messages[topic]
    }
    known = {name: name for name in vocabulary.signals} | fields
    found: dict[Variable, str] = {}
    for variable in sorted(variables_of(pattern)) if pattern is not None else ():
        name = variable[:1].lower() + variable[1:]
        if name not in known:
            raise ConformanceError(
                f"{owner}: {variable} is no field of its message and no signal{nearest(name, known)}"
            )
        found[variable] = known[name]
    return found


def _check_limits(declaration: Conformance, program: Program, parameters: frozenset[str]) -> None:
    beliefs = [each for each in program.beliefs if not isinstance(each, Rule)]
    known = [belief.functor for belief in beliefs if len(belief.args) == 1 and isinstance(belief.args[0], Number)]
    for name, limit in declaration.limits.items():
        if name not in known:
            raise ConformanceError(
                f"Conformance: limits: {declaration.agent} has no initial belief {name}(number){nearest(name, known)}"
            )
        if isinstance(limit, str):
            if limit not in parameters:
                raise ConformanceError(
                    f"Conformance: limits[{name!r}]: the run has no parameter {limit!r}{nearest(limit, parameters)}"
                )
        elif isinstance(limit, bool) or not isinstance(limit, int | float):
            raise ConformanceError(
                f"Conformance: limits[{name!r}] is {limit!r}; expected a number, or the name of a parameter of the run"
            )
