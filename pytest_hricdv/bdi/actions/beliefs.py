"""Internal actions that query or change beliefs."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.bdi.actions.registry import Invocation, internal_action
from pytest_hricdv.bdi.agent.agent_state import Outcome
from pytest_hricdv.bdi.language.syntax import Rule
from pytest_hricdv.bdi.language.terms import ListTerm as List
from pytest_hricdv.bdi.language.terms import Number, Structure, Term, term_order
from pytest_hricdv.bdi.logic.inference import first, solve
from pytest_hricdv.bdi.logic.unify import undo, unify


def _found(invocation: Invocation) -> list[Term]:
    """The first argument's value for every solution of the second."""
    agent = invocation.agent
    agent.enter_query(invocation.formula(1))
    try:
        solutions = solve(agent, invocation.formula(1), invocation.bindings)
        return [agent.value(invocation.args[0], solution) for solution in solutions]
    finally:
        agent.leave_query()


@internal_action("findall", 3)
def _findall(invocation: Invocation) -> Outcome:
    return invocation.unify(2, List(tuple(_found(invocation))))


@internal_action("setof", 3)
def _setof(invocation: Invocation) -> Outcome:
    return invocation.unify(2, List(tuple(sorted(set(_found(invocation)), key=term_order))))


@internal_action("count", 2)
def _count(invocation: Invocation) -> Outcome:
    agent = invocation.agent
    agent.enter_query(invocation.formula(0))
    try:
        number = sum(1 for _ in solve(agent, invocation.formula(0), invocation.bindings))
    finally:
        agent.leave_query()
    return invocation.unify(1, Number(number))


@internal_action("eval", 2)
def _eval(invocation: Invocation) -> Outcome:
    holds = first(invocation.agent, invocation.formula(1), invocation.bindings) is not None
    return invocation.unify(0, Structure("true" if holds else "false"))


@internal_action("belief", 1)
def _belief(invocation: Invocation) -> Iterator[object]:
    literal = invocation.literal(0)
    for entry in invocation.agent.beliefs.candidates(literal.key):
        if not isinstance(entry, Rule) and invocation.unify(0, entry):
            yield entry


@internal_action("abolish", 1)
def _abolish(invocation: Invocation) -> Outcome:
    """Remove every belief that matches, with all its sources; each removal is an event."""
    agent = invocation.agent
    pattern = invocation.literal(0)
    for entry in list(agent.beliefs.candidates(pattern.key)):
        if isinstance(entry, Rule):
            continue
        trail: list[object] = []
        matches = unify(pattern, entry, invocation.bindings, trail)  # type: ignore[arg-type]
        undo(invocation.bindings, trail, 0)  # type: ignore[arg-type]
        if matches:
            agent.disbelieve(entry)
    return True


@internal_action("perceive", 0)
def _perceive(invocation: Invocation) -> Outcome:
    return True
