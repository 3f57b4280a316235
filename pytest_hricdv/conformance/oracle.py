"""A declaration of conformance, checked against the model and the vocabulary, and made ready for following runs."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from pytest_hricdv.bdi import BdiError, Number, String, Structure, Term, Variable
from pytest_hricdv.bdi.language.parser import parse_literal
from pytest_hricdv.bdi.language.project import read_project
from pytest_hricdv.bdi.language.syntax import ExternalAction, Plan, Program, Rule
from pytest_hricdv.bdi.language.syntax_tree import parts_of, variables_of
from pytest_hricdv.bdi.language.terms import Call, Key
from pytest_hricdv.bdi.logic.substitution import substitute_only
from pytest_hricdv.bdi.run.system import AgentTemplate, read_templates
from pytest_hricdv.conformance.declaration import MODEL, PERCEPT, Conformance, ConformanceError, Does, Hears
from pytest_hricdv.generate.model import Model
from pytest_hricdv.monitor import FormulaSource, PastFormula, Value, Vocabulary, parse_condition
from pytest_hricdv.monitor.analysis import is_instantaneous, topics_of
from pytest_hricdv.suggestion import nearest

Bindings = dict[Variable, Term]

_ATOM = re.compile(r"[a-z][A-Za-z0-9_]*")


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
        """The values of the variables, by the last values of signals and fields."""
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
            raise ConformanceError(f"{_owner(hears)}: no agent {hears.source!r}{nearest(hears.source, others)}")
    names = _Names(agent.name, agent.program.plans)
    _check_limits(declaration, agent.program, frozenset(parameters))
    fails = {number: does for number, does in enumerate(declaration.does) if does.fails}
    return Oracle(
        declaration,
        agent,
        others,
        hears=tuple(_event(_owner(each), names.heard(each), each.when, vocabulary) for each in declaration.hears),
        does=tuple(_event(_owner(each), names.act(each), each.when, vocabulary) for each in declaration.does),
        fails={
            number: _event(f"{_owner(each)}, fails", names.failing(each), each.fails, vocabulary)
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


def term_of(value: Value) -> Term:
    """A value of a run as a term: True is 1; a text is an atom if it can be one, else a string."""
    return _text_term(value) if isinstance(value, str) else Number(value)


def _text_term(text: str) -> Term:
    return Structure(text) if _ATOM.fullmatch(text) else String(text)


def comparable(literal: Structure) -> Structure:
    """The literal with texts as `term_of` gives them, without annotations: `turn("released")` is `turn(released)`."""
    args = (_text_term(arg.value) if isinstance(arg, String) else arg for arg in literal.args)
    return Structure(literal.functor, tuple(args), (), literal.negated)


class _Names:
    """What an agent's source is about, for checks."""

    def __init__(self, agent: str, plans: tuple[Plan, ...]) -> None:
        self._agent = agent
        self._labels = [plan.label for plan in plans if plan.has_label]
        self._goals = _keys(plan.trigger for plan in plans if plan.trigger.sign == "+!")
        self._beliefs = _keys((plan.trigger, plan.context, plan.body) for plan in plans)
        self._actions = {
            part.action.key
            for plan in plans
            for part in parts_of(plan.body)
            if isinstance(part, ExternalAction) and isinstance(part.action, Structure)
        }
        self._acts = self._actions | _sent(plans)

    def heard(self, hears: Hears) -> Structure:
        literal = _literal(_owner(hears), hears.literal.removeprefix("!"))
        goal = hears.literal.startswith("!")
        self._require(_owner(hears), literal, "goal" if goal else "belief", self._goals if goal else self._beliefs)
        return literal

    def act(self, does: Does) -> Structure | None:
        owner = _owner(does)
        if does.act.startswith("@"):
            if does.act[1:] not in self._labels:
                raise ConformanceError(
                    f"{owner}: {self._agent} has no plan {does.act}{nearest(does.act[1:], self._labels)}"
                )
            return None
        literal = comparable(_literal(owner, does.act))
        self._require(owner, literal, "action or message", self._acts)
        return literal

    def failing(self, does: Does) -> Structure:
        owner = f"{_owner(does)}, fails"
        literal = None if does.act.startswith("@") else _literal(owner, does.act)
        if literal is None or literal.key not in self._actions:
            raise ConformanceError(f"{owner}: only an external action can fail; {does.act} is none of {self._agent}")
        return literal

    def _require(self, owner: str, literal: Structure, kind: str, known: set[Key]) -> None:
        if literal.key in known:
            return
        counts = sorted(arity for _, functor, arity in known if functor == literal.functor)
        if counts:
            problem = f"with {len(literal.args)} arguments; it has {' or '.join(map(str, counts))}"
        else:
            problem = nearest(literal.functor, sorted({functor for _, functor, _ in known}))
        raise ConformanceError(f"{owner}: {self._agent} has no {kind} {literal.functor} {problem}".replace(" ;", ";"))


def _keys(parts: Iterable[object]) -> set[Key]:
    structures = (part for each in parts for part in parts_of(each) if isinstance(part, Structure))
    return {part.key for part in structures if part.functor not in ("source", "true", "false")}


def _sent(plans: Iterable[Plan]) -> set[Key]:
    """The predicates of what is sent; of all that the plans mention, if a variable stands for what is sent."""
    found: set[Key] = set()
    for plan in plans:
        for call in parts_of(plan.body):
            if isinstance(call, Call) and call.name in CONTENT:
                content = call.args[CONTENT[call.name]]
                found |= _keys([content]) if isinstance(content, Structure) else _keys(each.body for each in plans)
    return found


CONTENT = {".send": 2, ".broadcast": 1}
"""The place of the content among the arguments of the actions that send a message."""


def window_text(first_s: float, last_s: float) -> str:
    """The time for an act, from when the agent is ready for it: `within 10 s`, or `after 2 to 10 s`."""
    return f"within {last_s:g} s" if first_s == 0 else f"after {first_s:g} to {last_s:g} s"


def _owner(part: Hears | Does) -> str:
    return f"Hears({part.literal!r})" if isinstance(part, Hears) else f"Does({part.act!r})"


def _literal(owner: str, text: str) -> Structure:
    try:
        return parse_literal(text)
    except BdiError as error:
        raise ConformanceError(f"{owner}: {error}") from None


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
