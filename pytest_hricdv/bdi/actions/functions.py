"""Functions in expressions, such as ``math.abs(X)`` and ``.length(L)``.

`function_value` computes the value of one for an agent; `StandardActions.function` calls it.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable
from functools import partial

from pytest_hricdv.bdi.actions.registry import FUNCTIONS, check_exists, is_function
from pytest_hricdv.bdi.agent.agent_state import AgentState
from pytest_hricdv.bdi.language.collection import CollectionTerm
from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.syntax_tree import call_with_values
from pytest_hricdv.bdi.language.terms import (
    NOT_NUMERIC,
    VALUE_BY_RULE,
    Call,
    ListTerm,
    Number,
    String,
    Structure,
    Term,
    Variable,
    is_ground,
    render,
)
from pytest_hricdv.bdi.logic.inference import first, solve
from pytest_hricdv.bdi.logic.substitution import Bindings


def _round(value: float) -> float:
    # As java.lang.Math.round: halves go up, also those below 0. Python's round goes to the even neighbour.
    return math.floor(value + 0.5)


def _real(function: Callable[[float], float]) -> Callable[[float], float]:
    """The function, but with NaN where it has no value, as in Java."""

    def value(x: float) -> float:
        try:
            return function(x)
        except ValueError:
            return math.nan

    return value


def _log(x: float) -> float:
    # As in Java; Python raises.
    return -math.inf if x == 0.0 else math.log(x)


def _std_dev(values: list[float]) -> float:
    # The deviation of a sample, as in Jason; one number has none.
    return statistics.stdev(values) if len(values) > 1 else math.nan


_OF_NUMBERS: dict[str, tuple[int, Callable[..., float]]] = {
    "math.abs": (1, abs),
    "math.acos": (1, _real(math.acos)),
    "math.asin": (1, _real(math.asin)),
    "math.atan": (1, math.atan),
    "math.ceil": (1, math.ceil),
    "math.cos": (1, math.cos),
    "math.floor": (1, math.floor),
    "math.log": (1, _real(_log)),
    "math.round": (1, _round),
    "math.sin": (1, math.sin),
    "math.sqrt": (1, _real(math.sqrt)),
    "math.tan": (1, math.tan),
    "math.e": (0, lambda: math.e),
    "math.pi": (0, lambda: math.pi),
}
_OF_LISTS: dict[str, Callable[[list[float]], float]] = {
    "math.average": statistics.fmean,
    "math.mean": statistics.fmean,
    "math.max": max,
    "math.median": statistics.median,
    "math.min": min,
    "math.std_dev": _std_dev,
    "math.sum": math.fsum,
}

FUNCTIONS.update({name: (arity, arity) for name, (arity, _) in _OF_NUMBERS.items()})
FUNCTIONS.update(dict.fromkeys(_OF_LISTS, (1, 2)))
FUNCTIONS.update(
    {"math.random": (0, 1), "system.time": (0, 0), VALUE_BY_RULE: (1, 1), ".length": (1, 1), ".count": (1, 1)}
)


def function_value(agent: AgentState, call: Call, bindings: Bindings) -> Term:
    """The value of a function call in an expression.

    Returns:
        A number, or the call itself as long as its arguments are not bound, or if it has no value for them.

    Raises:
        EvaluationError: it is not a function.
    """
    if call.name == NOT_NUMERIC:
        agent.run.warn(f"{agent.name}: {agent.activity()}: {call.args[0]} is not a number, in {render(call.args[1])}")  # type: ignore[arg-type]
        return Number(math.nan)
    if not is_function(call):
        check_exists(call)
        # As in Jason, an action in the place of a term is passed on, and is a condition where its variable is one.
        return call_with_values(call, partial(agent.value, bindings=bindings))
    if call.name == ".count":
        return Number(sum(1 for _ in solve(agent, call.args[0], bindings)))  # type: ignore[arg-type, misc]
    args = [agent.value(arg, bindings) for arg in call.args]  # type: ignore[arg-type]
    if not all(map(is_ground, args)):
        return Call(call.name, tuple(args), call.location)
    if call.name == VALUE_BY_RULE:
        return _value_by_rule(agent, args[0])
    try:
        return Number(_value(agent, call.name, args))
    except (ArithmeticError, ValueError, TypeError, statistics.StatisticsError):
        agent.run.warn(f"{agent.name}: {agent.activity()}: {call.name}({','.join(map(str, args))}) has no value")
        return call


def _value_by_rule(agent: AgentState, term: Term) -> Term:
    """The last argument of the first belief or rule with the arguments of a registered function."""
    assert isinstance(term, Structure)
    value = Variable("_Value")
    query = Structure(term.functor, (*term.args, value))
    agent.enter_query(query)
    try:
        solution = first(agent, query, {})
        if solution is None:
            raise EvaluationError(f"{query} has no answer, so that the function {term.functor} has no value")
        return agent.value(value, solution)
    finally:
        agent.leave_query()


def _value(agent: AgentState, name: str, args: list[Term]) -> float:
    if name == "math.random":
        return agent.run.draw() * (_numbers(args)[0] if args else 1.0)
    if name == "system.time":
        agent.run.progress += 1
        return math.floor(agent.run.time_ms)
    if name == ".length":
        value = args[0]
        if isinstance(value, CollectionTerm):
            return len(value)
        return len(value.value) if isinstance(value, String) else len(value.items) if isinstance(value, ListTerm) else 0
    if name in _OF_LISTS:
        return _OF_LISTS[name](_numbers(args))
    return _OF_NUMBERS[name][1](*_numbers(args))


def _numbers(args: list[Term]) -> list[float]:
    terms = args[0].items if len(args) == 1 and isinstance(args[0], ListTerm) else args
    if not all(isinstance(term, Number) for term in terms):
        raise ValueError
    return [float(str(term)) if not isinstance(term, Number) else float(term) for term in terms]
