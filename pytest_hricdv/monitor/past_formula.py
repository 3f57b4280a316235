"""Past formulas as data: conditions that are true or false at each time, decided by the run up to that time.

The parser and `build` make them. Each class, such as `On`, says everything about its operator: its text, what it reads,
when it can change, and how it is compiled.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, ClassVar, Literal, Self

from pytest_hricdv.monitor.evaluation_state import nanoseconds
from pytest_hricdv.monitor.node import (
    Compiler,
    FormulaNode,
    HysteresisScope,
    Kind,
    PastFormula,
    Precedence,
    Term,
    TextTerm,
    is_optional,
    number_text,
)
from pytest_hricdv.monitor.operators import (
    ForOperator,
    OnceOperator,
    PreviouslyOperator,
    RiseOperator,
    SinceOperator,
    TimeSinceOperator,
)
from pytest_hricdv.monitor.terms import NumberTerm, TimeSince, window_of_past

Relation = Literal["<", "<=", ">", ">=", "==", "!="]
Equality = Literal["==", "!="]
FLIPPED: Mapping[Relation, Relation] = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!="}
"""The relation of the right side to the left one."""


def _duration(for_s: float) -> str:
    return f" [for {number_text(for_s)}]" if for_s else ""


@dataclass(frozen=True)
class BooleanName(PastFormula):
    """A boolean signal, `topic.field`, the last value of a boolean field, or `last(topic.field)`, the one before it."""

    name: str

    @property
    def own_names(self) -> dict[str, Kind]:
        return {self.name: bool}

    def __str__(self) -> str:
        return self.name

    def expression(self, compiler: Compiler, scope: HysteresisScope) -> str:
        return f"v.get({self.name!r}, False)" if is_optional(self.name, bool) else f"v[{self.name!r}]"


@dataclass(frozen=True)
class On(PastFormula):
    """True only at an instant at which a message of the topic arrives."""

    is_instantaneous = True
    is_right_continuous = False
    topic: str

    @property
    def sources(self) -> frozenset[str]:
        return frozenset((f"on({self.topic})",))

    def __str__(self) -> str:
        return f"on({self.topic})"

    def expression(self, compiler: Compiler, scope: HysteresisScope) -> str:
        return f"({self.topic!r} in m)"


@dataclass(frozen=True)
class NumberComparison(PastFormula):
    """`left relation right [hysteresis h] [for d]`.

    With a hysteresis, a comparison that became false is true again only when it passes the bound by `hysteresis` (same
    unit as the terms). With `for_s`, it is true once the comparison has held for that long without a break.
    """

    PRECEDENCE = Precedence.COMPARISON
    relation: Relation
    left: Term
    right: Term
    hysteresis: float = 0.0
    for_s: float = 0.0

    @property
    def is_right_continuous(self) -> bool:
        if isinstance(self.left, TimeSince):
            # `time_since(f) <= d` becomes false right after d, `time_since(f) < d` at d.
            return self.relation in ("<", ">=") and self.left.operand.is_right_continuous
        return self.left.is_right_continuous and self.right.is_right_continuous

    def __str__(self) -> str:
        left, right = self.left.operand_text(Precedence.SUM), self.right.operand_text(Precedence.SUM)
        hysteresis = f" [hysteresis {number_text(self.hysteresis)}]" if self.hysteresis else ""
        return f"{left} {self.relation} {right}{hysteresis}{_duration(self.for_s)}"

    def expression(self, compiler: Compiler, scope: HysteresisScope) -> str:
        if self.for_s > 0:
            return compiler.output(self, _with_duration(self.for_s), replace(self, for_s=0.0))
        match self.left, self.right:
            case TimeSince(operand), NumberTerm(bound_s):
                closed = self.relation in ("<=", ">")
                elapsed = partial(TimeSinceOperator, bound_ns=nanoseconds(bound_s), closed=closed)
                output = compiler.output(self, elapsed, operand)
                return output if self.relation in ("<", "<=") else f"(not {output})"
        return compiler.comparison(self, scope)

    def robustness(self, compiler: Compiler) -> str | None:
        return None if self.for_s or isinstance(self.left, TimeSince) else compiler.distance(self)


@dataclass(frozen=True)
class TextComparison(PastFormula):
    """`left == right [for d]` or `left != right [for d]`, of strings."""

    PRECEDENCE = Precedence.COMPARISON
    relation: Equality
    left: TextTerm
    right: TextTerm
    for_s: float = 0.0

    def __str__(self) -> str:
        return f"{self.left} {self.relation} {self.right}{_duration(self.for_s)}"

    def expression(self, compiler: Compiler, scope: HysteresisScope) -> str:
        if self.for_s > 0:
            return compiler.output(self, _with_duration(self.for_s), replace(self, for_s=0.0))
        return compiler.comparison_text(self)


def _with_duration(duration_s: float) -> Callable[..., ForOperator]:
    return partial(ForOperator, length_ns=nanoseconds(duration_s))


@dataclass(frozen=True)
class Negation(PastFormula):
    PRECEDENCE = Precedence.NOT
    operand: PastFormula

    def __str__(self) -> str:
        return f"!{self.operand.operand_text(Precedence.ATOM)}"

    def expression(self, compiler: Compiler, scope: HysteresisScope) -> str:
        return f"(not {self.operand.expression(compiler, scope)})"

    def robustness(self, compiler: Compiler) -> str | None:
        inner = self.operand.robustness(compiler)
        return None if inner is None else f"-{inner}"


@dataclass(frozen=True, init=False)
class _Connective(PastFormula):
    """A connective of two or more operands: a long one does not nest."""

    SYMBOL: ClassVar[str]
    WORD: ClassVar[str]
    DISTANCE: ClassVar[str]
    operands: tuple[PastFormula, ...]

    def __init__(self, *operands: PastFormula) -> None:
        object.__setattr__(self, "operands", operands)

    @property
    def parts(self) -> tuple[FormulaNode, ...]:
        return self.operands

    def __str__(self) -> str:
        within = Precedence(self.PRECEDENCE + 1)
        return f" {self.SYMBOL} ".join(operand.operand_text(within) for operand in self.operands)

    def with_operands(self, change: Callable[[Any], Any]) -> Self:
        return type(self)(*map(change, self.operands))

    def expression(self, compiler: Compiler, scope: HysteresisScope) -> str:
        return f"({f' {self.WORD} '.join([operand.expression(compiler, scope) for operand in self.operands])})"

    def robustness(self, compiler: Compiler) -> str | None:
        distances = [operand.robustness(compiler) for operand in self.operands]
        if not any(distances):
            return None
        parts = [
            distance or f"(INFINITY if {operand.expression(compiler, HysteresisScope.NEVER)} else -INFINITY)"
            for distance, operand in zip(distances, self.operands, strict=True)
        ]
        return f"{self.DISTANCE}({', '.join(parts)})"


class Conjunction(_Connective):
    PRECEDENCE, SYMBOL, WORD, DISTANCE = Precedence.AND, "&", "and", "min"

    @property
    def is_instantaneous(self) -> bool:
        return any(operand.is_instantaneous for operand in self.operands)

    @property
    def sources(self) -> frozenset[str]:
        # A conjunction with an operand that is true only at isolated instants can be true only at these, so updates of
        # the other operands alone do not matter: `fall(leg_held) & leg_offset < 0.15` is evaluated when `leg_held`
        # changes, however often `leg_offset` does. Any such operand will do; the first is often a message, which comes
        # more rarely than a signal.
        return next((operand.sources for operand in self.operands if operand.is_instantaneous), super().sources)


class Disjunction(_Connective):
    PRECEDENCE, SYMBOL, WORD, DISTANCE = Precedence.OR, "|", "or", "max"

    @property
    def is_instantaneous(self) -> bool:
        return all(operand.is_instantaneous for operand in self.operands)


@dataclass(frozen=True)
class NamedOperator(PastFormula):
    """An operator that is written as its lower-case class name, with one operand."""

    NEVER_OF_INSTANTS: ClassVar[str] = ""
    """Where the operand of the operator has to hold, if one that is true for single instants only never does."""
    ADVICE: ClassVar[str] = ""
    """Advice on what to write instead."""
    operand: PastFormula

    def __str__(self) -> str:
        return f"{type(self).__name__.lower()}({self.operand})"


class _Edge(NamedOperator):
    is_instantaneous = True
    is_right_continuous = False


class Rise(_Edge):
    """True only at an instant at which the operand becomes true, at that instant or right after it."""

    def expression(self, compiler: Compiler, scope: HysteresisScope) -> str:
        return compiler.output(self, RiseOperator, self.operand)


class Fall(_Edge):
    """True only at an instant at which the operand becomes false, at that instant or right after it."""

    def expression(self, compiler: Compiler, scope: HysteresisScope) -> str:
        return Rise(Negation(self.operand)).expression(compiler, scope)


class Previously(NamedOperator):
    """The operand just before: the left limit, not the previous sample, so that the sampling rate does not matter."""

    NEVER_OF_INSTANTS = "just before"
    ADVICE = "to ask whether it was true recently, write `once[0:d](...)`"
    is_right_continuous = False

    def expression(self, compiler: Compiler, scope: HysteresisScope) -> str:
        return compiler.output(self, PreviouslyOperator, self.operand)


@dataclass(frozen=True)
class WindowedOperator(NamedOperator):
    """A named operator over a window of the past; without a window: over the complete past."""

    start_s: float = 0.0
    end_s: float = math.inf

    def __str__(self) -> str:
        return f"{type(self).__name__.lower()}{window_of_past(self.start_s, self.end_s)}({self.operand})"


class Once(WindowedOperator):
    """At time t: the operand was true at some time in [t - end_s, t - start_s], within the run."""

    def expression(self, compiler: Compiler, scope: HysteresisScope) -> str:
        once = partial(OnceOperator, start_ns=nanoseconds(self.start_s), end_ns=nanoseconds(self.end_s))
        return compiler.output(self, once, self.operand)


class Historically(WindowedOperator):
    """At time t: the operand was true at all times in [t - end_s, t - start_s], within the run."""

    NEVER_OF_INSTANTS = "for a length of time"

    def expression(self, compiler: Compiler, scope: HysteresisScope) -> str:
        # Use the dual, so that only one operator implements windows.
        return f"(not {Once(Negation(self.operand), self.start_s, self.end_s).expression(compiler, scope)})"


@dataclass(frozen=True)
class Since(PastFormula):
    """`right` was true at some time, and `left` has been true at all times after it, up to now.

    It is enough that `left` becomes true at the very time at which `right` becomes false.
    """

    PRECEDENCE = Precedence.SINCE
    left: PastFormula
    right: PastFormula

    def __str__(self) -> str:
        return f"{self.left.operand_text(Precedence.OR)} since {self.right.operand_text(Precedence.OR)}"

    def expression(self, compiler: Compiler, scope: HysteresisScope) -> str:
        return compiler.output(self, SinceOperator, self.left, self.right)


OPERATORS: Mapping[str, type[NamedOperator]] = {
    operator.__name__.lower(): operator for operator in (Rise, Fall, Previously, Once, Historically)
}
"""The operators that are written as functions, by their words."""
