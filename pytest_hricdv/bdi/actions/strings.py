"""Internal actions on strings."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.bdi.actions.registry import WRONG, Invocation, internal_action
from pytest_hricdv.bdi.agent.agent_state import Outcome
from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.parser import parse_term
from pytest_hricdv.bdi.language.terms import Number, String
from pytest_hricdv.bdi.logic.unify import undo


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
def _replace(invocation: Invocation) -> Outcome:
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
