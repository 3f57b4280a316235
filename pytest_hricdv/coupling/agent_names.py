"""`AgentNames`: the goals, beliefs, plans and acts in an agent's source.

`read_agents` reads agents of a model. `load_role`, for interactive agents, and `load_oracle` then check that
declarations such as `PerceptMapping` use only names of the agent.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace

from pytest_hricdv._base.message import nearest
from pytest_hricdv.bdi import BdiError, Number, String, Structure, Term
from pytest_hricdv.bdi.language.parser import parse_literal
from pytest_hricdv.bdi.language.project import read_project
from pytest_hricdv.bdi.language.syntax import ExternalAction, Plan
from pytest_hricdv.bdi.language.syntax_tree import parts_of
from pytest_hricdv.bdi.language.terms import Call, Key
from pytest_hricdv.bdi.run.system import AgentTemplate, read_templates
from pytest_hricdv.coupling.percept_mapping import CouplingError, PerceptMapping
from pytest_hricdv.generate.model import Model
from pytest_hricdv.monitor import Value

_ATOM = re.compile(r"[a-z][A-Za-z0-9_]*")


def term_of(value: Value) -> Term:
    """A value of a run as a term: True is 1; a string becomes an atom if it can, else stays a string."""
    return _text_term(value) if isinstance(value, str) else Number(value)


def _text_term(text: str) -> Term:
    return Structure(text) if _ATOM.fullmatch(text) else String(text)


def comparable(literal: Structure) -> Structure:
    """The literal with texts as `term_of` gives them, without annotations: `turn("released")` is `turn(released)`."""
    args = (_text_term(arg.value) if isinstance(arg, String) else arg for arg in literal.args)
    return Structure(literal.functor, tuple(args), (), literal.negated)


CONTENT = {".send": 2, ".broadcast": 1}
"""Action that sends a message -> the index of the message's content among its arguments."""


class AgentNames:
    """The names in an agent's source."""

    def __init__(self, agent: str, plans: tuple[Plan, ...]) -> None:
        self._agent = agent
        self._labels = [f"@{plan.label}" for plan in plans if plan.has_label]
        self._goals = _keys(plan.trigger for plan in plans if plan.trigger.sign == "+!")
        achieved = [plan.trigger.literal for plan in plans if plan.trigger.sign == "+!"]
        plain = {goal.functor for goal in achieved if isinstance(goal, Structure) and not (goal.args or goal.negated)}
        self._plain_goals = tuple(sorted(plain))
        self._beliefs = _keys((plan.trigger, plan.context, plan.body) for plan in plans)
        self._actions = {
            part.action.key
            for plan in plans
            for part in parts_of(plan.body)
            if isinstance(part, ExternalAction) and isinstance(part.action, Structure)
        }
        self._acts = self._actions | _sender_names(plans)

    @property
    def plain_goals(self) -> tuple[str, ...]:
        """The goals without parameters that it has plans for, sorted."""
        return self._plain_goals

    def literal_of_percept(self, hears: PerceptMapping) -> Structure:
        """The literal of what it hears. Raises CouplingError for one that it does not know."""
        literal = _parse(hears.owner, hears.literal.removeprefix("!"))
        kind, predicates = ("goal", self._goals) if hears.is_goal else ("belief", self._beliefs)
        self._require(hears.owner, literal, kind, predicates)
        return literal

    def act(self, owner: str, act: str) -> Structure | None:
        """The literal of an act; None for a plan's label. Raises CouplingError for one that it does not have."""
        if act.startswith("@"):
            if act not in self._labels:
                raise CouplingError(f"{owner}: {self._agent} has no plan {act}{nearest(act, self._labels)}")
            return None
        literal = comparable(_parse(owner, act))
        self._require(owner, literal, "action or message", self._acts)
        return literal

    def literal_of_failure(self, owner: str, act: str) -> Structure:
        """The literal of an act that can fail. Raises CouplingError if it is not an external action."""
        literal = None if act.startswith("@") else _parse(owner, act)
        if literal is None or literal.key not in self._actions:
            raise CouplingError(f"{owner}: only an external action can fail; {act} is not one of {self._agent}")
        return literal

    def _require(self, owner: str, literal: Structure, kind: str, predicates: set[Key]) -> None:
        if literal.key in predicates:
            return
        counts = sorted(arity for _, functor, arity in predicates if functor == literal.functor)
        if counts:
            problem = f" with {len(literal.args)} arguments; it has {' or '.join(map(str, counts))}"
        else:
            problem = nearest(literal.functor, sorted({functor for _, functor, _ in predicates}))
        raise CouplingError(f"{owner}: {self._agent} has no {kind} {literal.functor}{problem}")


def _keys(parts: Iterable[object]) -> set[Key]:
    structures = (part for root in parts for part in parts_of(root) if isinstance(part, Structure))
    # The annotation [source(a)] and constant contexts are not beliefs.
    return {part.key for part in structures if part.functor not in ("source", "true", "false")}


def _sender_names(plans: Iterable[Plan]) -> set[Key]:
    """The predicates of what is sent; of all that the plans mention, if a variable stands for what is sent."""
    predicates: set[Key] = set()
    for plan in plans:
        for call in parts_of(plan.body):
            if isinstance(call, Call) and call.name in CONTENT:
                content = call.args[CONTENT[call.name]]
                predicates |= {content.key} if isinstance(content, Structure) else _keys(plan.body for plan in plans)
    return predicates


def _parse(owner: str, text: str) -> Structure:
    try:
        return parse_literal(text)
    except BdiError as error:
        raise CouplingError(f"{owner}: {error}") from None


def read_agents(wanted: Sequence[str], model: Model) -> tuple[tuple[AgentTemplate, ...], tuple[str, ...]]:
    """The agents of these names, and the names of all others, whose sources are not read: they can be large.

    Raises:
        CouplingError: there is no such agent, or the model cannot be read.
    """
    try:
        project = read_project(model.path)
        entries = {entry.name: entry for entry in project.agents}
        for name in wanted:
            if name not in entries:
                raise CouplingError(f"no agent {name!r} in {model.path}{nearest(name, entries)}")
        agents = read_templates(replace(project, agents=tuple(entries[name] for name in wanted)))
    except (BdiError, OSError) as error:
        raise CouplingError(f"BDI model {model.path}: {error}") from error
    return agents, tuple(name for name in entries if name not in wanted)
