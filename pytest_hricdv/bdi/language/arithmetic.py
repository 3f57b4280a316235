"""The values of arithmetic expressions, computed on doubles as in Jason."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.terms import Arithmetic, ListTerm, Number, Structure, Term, Variable, is_evaluable


def evaluated(expression: Arithmetic, operands: Sequence[Term]) -> Term:
    """The value of an expression with these operands in place of its own.

    Returns:
        A number; or an expression, if an operand has no value yet.

    Raises:
        EvaluationError: an operand is not a number, or the result is not defined.
    """
    numbers: list[float] = []
    for operand in operands:
        if isinstance(operand, Number):
            numbers.append(float(operand))
        elif isinstance(operand, Variable) or is_evaluable(operand):
            return Arithmetic(expression.operator, tuple(operands))
        else:
            raise EvaluationError(f"{operand} is not a number, in {expression}")
    if len(numbers) == 1:
        return Number(-numbers[0])
    try:
        return Number(OPERATIONS[expression.operator](*numbers))
    except (ArithmeticError, ValueError):
        raise EvaluationError(f"{Arithmetic(expression.operator, tuple(operands))} has no value") from None


def with_constants_evaluated(term: Term) -> Term:
    """The term with each expression without variables replaced by its value: ``p(1 + 2, X)`` is ``p(3, X)``.

    Raises:
        EvaluationError: see :func:`evaluated`.
    """
    if isinstance(term, Arithmetic):
        return evaluated(term, [with_constants_evaluated(operand) for operand in term.operands])
    if isinstance(term, Structure) and term.evaluable:
        args, annots = (tuple(map(with_constants_evaluated, part)) for part in (term.args, term.annots))
        return Structure(term.functor, args, (), term.negated).with_annotations(annots, term.annots_tail)
    if isinstance(term, ListTerm) and term.evaluable:
        return ListTerm(tuple(map(with_constants_evaluated, term.items)), term.tail)
    return term


def _divide(x: float, y: float) -> float:
    if y == 0.0:
        return math.nan if x == 0.0 else math.copysign(math.inf, x)
    return x / y


def _remainder(x: float, y: float) -> float:
    return math.nan if y == 0.0 or math.isinf(x) else math.fmod(x, y)


def _power(x: float, y: float) -> float:
    try:
        return math.pow(x, y)
    except OverflowError:
        return -math.inf if x < 0.0 and y % 2.0 == 1.0 else math.inf
    except ValueError:
        return math.inf if x == 0.0 else math.nan


# Integer division and remainder truncate towards zero, as on the Java numbers Jason computes with.
OPERATIONS: dict[str, Callable[..., float]] = {
    "+": lambda x, y: x + y,
    "-": lambda x, y: x - y,
    "*": lambda x, y: x * y,
    "/": _divide,
    "div": lambda x, y: float(math.trunc(math.trunc(x) / math.trunc(y))),
    "mod": _remainder,
    "**": _power,
}
