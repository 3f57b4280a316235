"""`@pattern` makes a pattern of a function from conditions and numbers to a formula: it checks the arguments' types.

The modules `temporal` and `collaboration` decorate their functions with it; a wrong argument raises `PatternError`.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from types import NoneType
from typing import ParamSpec, get_args

from pytest_hricdv.monitor.build import rise
from pytest_hricdv.monitor.dsl import NumberValue, TruthValue, as_number
from pytest_hricdv.monitor.formula import Formula

P = ParamSpec("P")

_EXPECTED = {
    TruthValue: "a condition, such as on(topic)",
    NumberValue: "a signal or field that is a number",
    float: "a number",
    int: "a whole number",
}


class PatternError(ValueError):
    """A pattern was used with a wrong argument.

    Attributes:
        argument: its name; empty if several arguments do not go together.
        problem: what was expected and what came.
    """

    def __init__(self, argument: str, problem: str) -> None:
        super().__init__(f"{argument}: {problem}" if argument else problem)
        self.argument = argument
        self.problem = problem


def pattern(function: Callable[P, Formula]) -> Callable[P, Formula]:
    """Decorates a pattern: each call checks that the arguments are of the annotated types.

    The types are TruthValue, NumberValue, float (finite, at least 0) and int; None is allowed where it is the default.

    Raises:
        PatternError: (of the pattern) an argument is of another type, or a number is negative or not finite.
    """
    signature = inspect.signature(function, eval_str=True)

    @functools.wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> Formula:
        for name, value in signature.bind(*args, **kwargs).arguments.items():
            _check(name, value, argument_types(signature.parameters[name]))
        return function(*args, **kwargs)

    return call


def argument_types(parameter: inspect.Parameter) -> tuple[type, ...]:
    """The types that a parameter of a pattern takes, in the order of its annotation."""
    return get_args(parameter.annotation) or (parameter.annotation,)


def _check(name: str, value: object, types: tuple[type, ...]) -> None:
    if value is None and NoneType in types:
        return
    if isinstance(value, int | float) and not isinstance(value, bool) and float in types:
        try:
            as_number(value, name)
        except ValueError:
            raise PatternError(name, f"expected a finite number of at least 0, got {value:g}") from None
    elif not isinstance(value, types) or isinstance(value, bool):
        expected = " or ".join(_EXPECTED[kind] for kind in types if kind is not NoneType)
        raise PatternError(name, f"expected {expected}, got {value!r}")


def require_duration(condition: TruthValue, argument: str) -> TruthValue:
    """The condition, which has to be one that can hold for a length of time.

    Raises:
        PatternError: it is true for single instants only.
    """
    if condition.past.is_instantaneous:
        problem = f"`{condition.past}` is true for single instants only; expected a condition that lasts"
        raise PatternError(argument, problem)
    return condition


def as_event(condition: TruthValue) -> TruthValue:
    """The instants at which a condition becomes true: of one that is true for single instants only, these."""
    return condition if condition.past.is_instantaneous else rise(condition)
