"""Internal actions that look at terms."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count

from pytest_hricdv.bdi.actions.registry import Invocation, internal_action
from pytest_hricdv.bdi.agent.agent_state import Outcome
from pytest_hricdv.bdi.agent.messages import add_source, text_of
from pytest_hricdv.bdi.language.terms import ListTerm, Number, String, Structure, Variable, is_ground


@internal_action("ground", 1)
def _ground(invocation: Invocation) -> Outcome:
    return is_ground(invocation.value(0))


@internal_action("number", 1)
def _number(invocation: Invocation) -> Outcome:
    return isinstance(invocation.value(0), Number)


@internal_action("string", 1)
def _string(invocation: Invocation) -> Outcome:
    return isinstance(invocation.value(0), String)


@internal_action("var", 1)
def _var(invocation: Invocation) -> Outcome:
    return isinstance(invocation.value(0), Variable)


@internal_action("atom", 1)
def _atom(invocation: Invocation) -> Outcome:
    value = invocation.value(0)
    return isinstance(value, Structure) and not value.args and not value.annots and not value.negated


@internal_action("structure", 1)
def _structure(invocation: Invocation) -> Outcome:
    return isinstance(invocation.value(0), (Structure, ListTerm))


@internal_action("literal", 1)
def _literal(invocation: Invocation) -> Outcome:
    return isinstance(invocation.value(0), Structure)


@internal_action("add_annot", 3)
def _add_annot(invocation: Invocation) -> Outcome:
    literal = invocation.literal(0)
    return invocation.unify(2, literal.with_annotations((*literal.annots, invocation.value(1))))


@internal_action("add_nested_source", 3)
def _add_nested_source(invocation: Invocation) -> Outcome:
    return invocation.unify(2, add_source(invocation.value(0), text_of(invocation.value(1))))


@internal_action("my_name", 1)
def _my_name(invocation: Invocation) -> Outcome:
    return invocation.unify(0, Structure(invocation.agent.name))


@internal_action("random", 1, 2)
def _random(invocation: Invocation) -> Outcome:
    """``.random(X)``, a number; ``.random(X, 5)``, up to five, one a solution; ``.random(Items, X)``, one of a list."""
    if len(invocation) == 1:
        return invocation.unify(0, Number(invocation.agent.run.draw()))
    if not isinstance(invocation.value(0), ListTerm):
        return _several_random(invocation, int(invocation.number(1)))
    drawn, items = invocation.agent.run.draw(), invocation.items(0)
    return bool(items) and invocation.unify(1, items[int(drawn * len(items))])


def _several_random(invocation: Invocation, most: int) -> Iterator[object]:
    """Numbers without end if asked for none."""
    for number in count() if most == 0 else range(most):
        if invocation.unify(0, Number(invocation.agent.run.draw())):
            yield number
