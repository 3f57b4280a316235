"""Plans, events and bodies as terms: what they become when their variables get values."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from pytest_hricdv.bdi.language.syntax import Act, Statement, children_names, variables_of
from pytest_hricdv.bdi.language.terms import Annotated, Arithmetic, Call, ListTerm, Quoted, Structure, Term, Variable

Valuation = Callable[[Term], Term]
"""Gives the value of a term, with its variables replaced."""
_VALUED = (Variable, Structure, ListTerm, Arithmetic, Annotated, Quoted)


def with_values(quoted: Quoted, value: Valuation) -> Quoted:
    """The term with its variables replaced that have values; ``{ !g; B }`` takes in the body that B stands for."""
    return Quoted(_valued(quoted.plan, value)) if variables_of(quoted) else quoted


def _valued(part: Any, value: Valuation) -> Any:
    if isinstance(part, tuple):
        return tuple(each for item in part for each in _several(item, value))
    if isinstance(part, _VALUED):
        return value(part)
    if isinstance(part, Call):
        # What it does is done when the body is executed.
        return Call(part.name, _valued(part.args, value), part.location)
    names = children_names(part)
    if not names or type(part).__module__ == Quoted.__module__:
        return part
    return replace(part, **{name: _valued(getattr(part, name), value) for name in names})


def _several(part: Any, value: Valuation) -> tuple[Statement, ...]:
    """What takes the place of one item: of a statement that is a variable, the body it stands for."""
    if isinstance(part, Act) and isinstance(part.action, Variable):
        done = value(part.action)
        if isinstance(done, Quoted) and isinstance(done.plan, tuple):
            return done.plan
    return (_valued(part, value),)
