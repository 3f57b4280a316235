"""A requirement's formula compiled to Python functions, once, for all runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache

from pytest_hricdv.monitor.analysis import conditions, is_lasting, names_read, sources, topics_read
from pytest_hricdv.monitor.expression import ExpressionWriter, HysteresisScope, function_of
from pytest_hricdv.monitor.formula import AlwaysWithin, Eventually, Formula, Holds, HoldsUntil
from pytest_hricdv.monitor.operators import HysteresisOperator, Operator
from pytest_hricdv.monitor.view import Condition, Robustness


@dataclass(frozen=True)
class Program:
    """What the monitors of one requirement run.

    Attributes:
        antecedent, condition: the two sides; `condition` is the formula inside the response.
        release: the right side of `until`.
        robustness: the signed distance of `condition` to its bounds; None if it compares nothing, or for `eventually`.
        operators: make the stateful operators, in the order in which they have to be stepped.
        latches: make the comparisons with hysteresis of a state response, which start afresh with each attempt.
        lasting: the value at an instant is also the value right after it (see `analysis.is_lasting`).
        kinds: signals and fields read -> type.
        topics: topics whose messages are read.
        always_sources: sources whose updates have to be looked at in any case.
        attempt_sources: sources whose updates have to be looked at only while an attempt is open.
    """

    antecedent: Condition
    condition: Condition
    release: Condition | None
    robustness: Robustness | None
    operators: tuple[Callable[[], Operator], ...]
    latches: tuple[Callable[[], HysteresisOperator], ...]
    lasting: bool
    kinds: Mapping[str, type[bool] | type[float]]
    topics: frozenset[str]
    always_sources: frozenset[str]
    attempt_sources: frozenset[str]


@lru_cache(maxsize=1024)
def compile_formula(formula: Formula) -> Program:
    """Compile a formula; equal formulas share one program."""
    writer = ExpressionWriter()
    response = formula.response
    antecedent = writer.condition(formula.antecedent, HysteresisScope.RUN)
    condition = writer.condition(response.condition, _scope_of_response(formula))
    release = writer.condition(response.release, HysteresisScope.RUN) if isinstance(response, HoldsUntil) else None
    robustness = None if isinstance(response, Eventually) else writer.robustness(response.condition)
    parts = conditions(response)
    return Program(
        antecedent=function_of(antecedent),
        condition=function_of(condition),
        release=None if release is None else function_of(release),
        robustness=None if robustness is None else function_of(robustness),
        operators=tuple(writer.operators),
        latches=tuple(writer.latches),
        lasting=is_lasting(formula.antecedent) and all(map(is_lasting, parts)),
        kinds=names_read(formula),
        topics=topics_read(formula),
        always_sources=sources(formula.antecedent).union(*writer.operator_sources),
        attempt_sources=frozenset().union(*map(sources, parts), *writer.latch_sources),
    )


def _scope_of_response(formula: Formula) -> HysteresisScope:
    """A value inside the bound must not be blamed on a violation that was no business of the attempt.

    A state response starts each attempt afresh. An attempt of `always[a:b]` and of `until` ends with its first
    violation, which is decided at the bound itself, so there the hysteresis has nothing to do.
    """
    match formula.response:
        case Holds():
            return HysteresisScope.ATTEMPT
        case AlwaysWithin() | HoldsUntil():
            return HysteresisScope.NEVER
        case _:
            return HysteresisScope.RUN
