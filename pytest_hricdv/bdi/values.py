"""Terms made ready to be evaluated often: a function for each, made once, that gives its value.

Only what has a plain value is done here: ground terms, bound variables, arithmetic on numbers, structures of these.
For anything else such a function gives None, and the term is for :func:`~.substitution.substitute`, which knows all
terms, and what to say of one that has no value. Evaluating a term twice does no harm: functions, which may draw random
numbers, are none of the terms done here.
"""

from __future__ import annotations

import operator
from collections.abc import Callable

from pytest_hricdv.bdi.language.arithmetic import OPERATIONS
from pytest_hricdv.bdi.language.terms import (
    Arithmetic,
    Number,
    String,
    Structure,
    Term,
    Variable,
    ground_structure,
    is_ground,
)
from pytest_hricdv.bdi.logic.substitution import Bindings

Value = Callable[[Bindings], Term | None]
"""Gives the ground value of a term; None if it has none, or none that is plain to see."""
Arguments = Callable[[Bindings], tuple[Term, ...] | None]
"""Gives the ground values of several terms; None if not all have one that is plain to see."""

_BUILT_IN: dict[str, Callable[[float, float], float]] = {"+": operator.add, "-": operator.sub, "*": operator.mul}
"""Operations that never fail, in their fastest form."""


def value_of(term: Term) -> Value | None:
    """How to get the value of a term; None if that is for :func:`substitute`."""
    if is_ground(term):
        return lambda bindings: term
    if isinstance(term, Variable):
        return _variable(term)
    if isinstance(term, Arithmetic):
        return _arithmetic(term)
    if isinstance(term, Structure) and not term.annots and term.annots_tail is None:
        return _structure(term)
    return None


def arguments_of(literal: Structure) -> Arguments | None:
    """How to get the values of a literal's arguments; None if that is for :func:`substitute`."""
    values = []
    for arg in literal.args:
        value = value_of(arg)
        if value is None:
            return None
        values.append(value)

    def arguments(bindings: Bindings) -> tuple[Term, ...] | None:
        args = []
        for value in values:
            arg = value(bindings)
            if arg is None:
                return None
            args.append(arg)
        return tuple(args)

    return arguments


def _variable(variable: Variable) -> Value:
    def value(bindings: Bindings) -> Term | None:
        bound = bindings.get(variable)
        kind = type(bound)
        if kind is Number or kind is String:
            return bound
        return bound if bound is not None and is_ground(bound) else None

    return value


def _structure(term: Structure) -> Value | None:
    arguments = arguments_of(term)
    if arguments is None:
        return None
    key = term.key

    def value(bindings: Bindings) -> Term | None:
        args = arguments(bindings)
        return None if args is None else ground_structure(key, args, ())

    return value


def _arithmetic(term: Arithmetic) -> Value | None:
    if len(term.operands) == 1:
        return None
    left, right = term.operands
    built_in = _BUILT_IN.get(term.operator)
    if built_in is not None and isinstance(left, Variable) and isinstance(right, Number):
        return _of_variable(built_in, left, right)
    if built_in is not None and isinstance(left, Variable) and isinstance(right, Variable):
        return _of_variables(built_in, left, right)
    first, second = value_of(left), value_of(right)
    if first is None or second is None:
        return None
    operation = built_in or OPERATIONS[term.operator]

    def value(bindings: Bindings) -> Term | None:
        x, y = first(bindings), second(bindings)
        if type(x) is not Number or type(y) is not Number:
            return None
        try:
            return Number(operation(x, y))
        except (ArithmeticError, ValueError):
            return None

    return value


def _of_variable(operation: Callable[[float, float], float], variable: Variable, number: Number) -> Value:
    """The commonest of all expressions, such as ``N + 1``."""

    def value(bindings: Bindings) -> Term | None:
        bound = bindings.get(variable)
        return Number(operation(bound, number)) if type(bound) is Number else None

    return value


def _of_variables(operation: Callable[[float, float], float], left: Variable, right: Variable) -> Value:
    """The next commonest, such as ``Now - Since``."""

    def value(bindings: Bindings) -> Term | None:
        x, y = bindings.get(left), bindings.get(right)
        return Number(operation(x, y)) if type(x) is Number and type(y) is Number else None

    return value
