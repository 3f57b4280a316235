"""Internal actions on terms and strings."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count

from pytest_hricdv.bdi.actions.registry import WRONG, Invocation, internal_action
from pytest_hricdv.bdi.agent.agent_state import Outcome
from pytest_hricdv.bdi.agent.messages import add_source, text_of
from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.parser import parse_term
from pytest_hricdv.bdi.language.terms import ListTerm, Number, String, Structure, Variable, is_ground
from pytest_hricdv.bdi.logic.unify import undo


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


@internal_action("substring", 2, 4)
def _substring(invocation: Invocation) -> Iterator[object]:
    """Where the first argument is in the second; if that is free, what is between two places of the first."""
    if invocation.is_free(1) and len(invocation) > 2:
        whole = invocation.text(0)
        start = int(invocation.number(2))
        end = int(invocation.number(3)) if len(invocation) == 4 else len(whole)
        if not 0 <= start <= end <= len(whole):
            raise EvaluationError(f"{invocation.call}: no places {start} to {end} in {len(whole)} characters", WRONG)
        if invocation.unify(1, String(whole[start:end])):
            yield start
        return
    part, text = invocation.text(0), invocation.text(1)
    start = text.find(part)
    while start >= 0:
        mark = len(invocation.trail)
        found = len(invocation) < 3 or invocation.unify(2, Number(start))
        if found and (len(invocation) < 4 or invocation.unify(3, Number(start + len(part)))):
            yield start
        else:
            undo(invocation.bindings, invocation.trail, mark)
        start = text.find(part, start + 1)


@internal_action("replace", 4)
def _replace_text(invocation: Invocation) -> Outcome:
    return invocation.unify(3, String(invocation.text(0).replace(invocation.text(1), invocation.text(2))))


@internal_action("lower_case", 2)
def _lower_case(invocation: Invocation) -> Outcome:
    return invocation.unify(1, String(invocation.text(0).lower()))


@internal_action("upper_case", 2)
def _upper_case(invocation: Invocation) -> Outcome:
    return invocation.unify(1, String(invocation.text(0).upper()))


@internal_action("term2string", 2)
def _term2string(invocation: Invocation) -> Outcome:
    if invocation.is_free(0):
        return invocation.unify(0, invocation.read(invocation.text(1), parse_term))
    return invocation.unify(1, String(str(invocation.value(0))))
