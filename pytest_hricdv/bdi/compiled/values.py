"""Terms of a program as Python expressions."""

from __future__ import annotations

import re

from pytest_hricdv.bdi.language.terms import Arithmetic, Number, String, Structure, Term, Variable, is_name

from .writer import UnsupportedError, Writer

Scope = dict[Variable, str]
"""The Python names of the variables that certainly have a value."""

_CHECKED = re.compile(r"\((\w+) if type\(\1\) is Number else bail\(\)\)")
"""A variable that has to stand for a number."""
_INLINE = frozenset({"+", "-", "*"})
"""Operators that never fail on numbers."""


def value(writer: Writer, term: Term, scope: Scope) -> str:
    """An expression for a term whose variables are all bound.

    Raises:
        UnsupportedError: they are not, or the term holds something else to be evaluated.
    """
    if isinstance(term, Variable):
        return _bound(term, scope)
    if isinstance(term, Arithmetic):
        return f"number_of({number(writer, term, scope)})"
    if isinstance(term, (Number, String)):
        return writer.names.constant(term)
    if isinstance(term, Structure):
        if term.ground:
            return writer.names.constant(term)
        if not term.annots and term.annots_tail is None:
            return f"Structure({term.functor!r}, {values(writer, term.args, scope)}, (), {term.negated})"
    raise UnsupportedError(f"{term} is not compiled")


def values(writer: Writer, terms: tuple[Term, ...], scope: Scope) -> str:
    """An expression for a tuple of terms."""
    if all(isinstance(term, (Number, String)) or (isinstance(term, Structure) and term.ground) for term in terms):
        return writer.names.constant(terms) if terms else "()"
    return f"({', '.join(value(writer, term, scope) for term in terms)},)"


def number(writer: Writer, term: Term, scope: Scope) -> str:
    """An expression for a Python float; what is no number is left to the interpreter, which knows what to say."""
    if isinstance(term, Number):
        return repr(float(term)) if term == term and abs(term) < 1e300 else f"float({writer.names.constant(term)})"
    if isinstance(term, Variable):
        name = _bound(term, scope)
        return f"({name} if type({name}) is Number else bail())"
    if isinstance(term, Arithmetic) and term.operator in _INLINE:
        operands = [number(writer, operand, scope) for operand in term.operands]
        return f"(-{operands[0]})" if len(operands) == 1 else f"({operands[0]} {term.operator} {operands[1]})"
    if isinstance(term, Arithmetic):
        operands = [number(writer, operand, scope) for operand in term.operands]
        return f"compute({term.operator!r}, {', '.join(operands)})"
    raise UnsupportedError(f"{term} is not compiled as a number")


def equality(writer: Writer, name: str, term: Term, scope: Scope) -> str:
    """An expression for whether the value of a Python name unifies with a term whose variables are all bound."""
    if isinstance(term, (Number, String)):
        return f"{name} == {writer.names.constant(term)}"
    if is_name(term):
        constant = writer.names.constant(term)
        return f"({name} is {constant} or same({name}, {constant}))"
    if isinstance(term, Variable):
        return f"same({name}, {_bound(term, scope)})"
    raise UnsupportedError(f"{term} is not compiled as a pattern")


def _bound(variable: Variable, scope: Scope) -> str:
    if variable not in scope:
        raise UnsupportedError(f"{variable} may have no value")
    return scope[variable]


def may_bail(*expressions: str) -> bool:
    """Whether one of these expressions may have no value."""
    return any(call in each for each in expressions for call in ("bail()", "compute(", "same(", "exists"))


def trusting(expression: str) -> tuple[str, list[str]]:
    """An expression without looking whether variables stand for numbers, and those variables."""
    return _CHECKED.sub(r"\1", expression), _CHECKED.findall(expression)
