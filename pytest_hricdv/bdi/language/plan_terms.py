"""Plans, events and bodies as terms: what they become when their variables get values."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from pytest_hricdv.bdi.language.syntax import ExternalAction, Statement, child_fields, variables_of
from pytest_hricdv.bdi.language.terms import (
    AnnotatedVariable,
    Arithmetic,
    Call,
    ListTerm,
    PlanTerm,
    Structure,
    Term,
    Variable,
)

Valuation = Callable[[Term], Term]
"""Gives the value of a term, with its variables replaced."""
_VALUED = (Variable, Structure, ListTerm, Arithmetic, AnnotatedVariable, PlanTerm)


def with_values(quoted: PlanTerm, value: Valuation) -> PlanTerm:
    """The term with its variables replaced that have values; ``{ !g; B }`` takes in the body that B stands for."""
    return PlanTerm(_valued(quoted.plan, value)) if variables_of(quoted) else quoted


def _valued(part: Any, value: Valuation) -> Any:
    if isinstance(part, tuple):
        return tuple(each for item in part for each in _several(item, value))
    if isinstance(part, _VALUED):
        return value(part)
    if isinstance(part, Call):
        # What it does is done when the body is executed.
        return Call(part.name, _valued(part.args, value), part.location)
    names = child_fields(part)
    if not names or type(part).__module__ == PlanTerm.__module__:
        return part
    return replace(part, **{name: _valued(getattr(part, name), value) for name in names})


def _several(part: Any, value: Valuation) -> tuple[Statement, ...]:
    """What takes the place of one item: of a statement that is a variable, the body it stands for."""
    if isinstance(part, ExternalAction) and isinstance(part.action, Variable):
        done = value(part.action)
        if isinstance(done, PlanTerm) and isinstance(done.plan, tuple):
            return done.plan
    return (_valued(part, value),)
