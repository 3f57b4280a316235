"""The formula of a requirement as data: `always(antecedent -> response)`.

A formula is about a run in dense time: signals are constant between their updates, a message is there for one instant.
Every node is a frozen dataclass that compares by value, so that equal requirements share one compiled program.
`str` of a node is its text in the requirement language, which parses back to an equal node. Times are seconds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

ArithmeticOperator = Literal["+", "-", "*", "/"]
Relation = Literal["<", "<=", ">", ">=", "==", "!="]


class Node:
    """Any part of a formula."""

    def __str__(self) -> str:
        # Here, because the text is written by what the nodes are, so that module needs this one.
        from pytest_hricdv.monitor.text import text_of

        return text_of(self)


# --- terms: numbers -----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Number(Node):
    value: float


@dataclass(frozen=True)
class FloatName(Node):
    """A float signal, or `topic.field`: the last value of a float field."""

    name: str


@dataclass(frozen=True)
class Negative(Node):
    operand: Term


@dataclass(frozen=True)
class Arithmetic(Node):
    operator: ArithmeticOperator
    left: Term
    right: Term


Term = Number | FloatName | Negative | Arithmetic


# --- past formulas: true or false at each time, by what has been so far ---------------------------------------------


@dataclass(frozen=True)
class BooleanName(Node):
    """A boolean signal, or `topic.field`: the last value of a boolean field."""

    name: str


@dataclass(frozen=True)
class On(Node):
    """True only at an instant at which a message of the topic arrives."""

    topic: str


@dataclass(frozen=True)
class Comparison(Node):
    """`left relation right [hysteresis h] [for d]`.

    With a hysteresis, once false it is true again only past the bound by `hysteresis` (same unit as the terms).
    With `for_s`, it is true once the comparison has held for that long without a break.
    """

    relation: Relation
    left: Term
    right: Term
    hysteresis: float = 0.0
    for_s: float = 0.0


@dataclass(frozen=True)
class Not(Node):
    operand: Past


@dataclass(frozen=True)
class And(Node):
    left: Past
    right: Past


@dataclass(frozen=True)
class Or(Node):
    left: Past
    right: Past


@dataclass(frozen=True)
class Rise(Node):
    """True only at an instant at which the operand turns true, at that instant or right after it."""

    operand: Past


@dataclass(frozen=True)
class Fall(Node):
    """True only at an instant at which the operand turns false, at that instant or right after it."""

    operand: Past


@dataclass(frozen=True)
class Once(Node):
    """At time t: the operand was true somewhere in [t - end_s, t - start_s], within the run."""

    operand: Past
    start_s: float = 0.0
    end_s: float = math.inf


@dataclass(frozen=True)
class Historically(Node):
    """At time t: the operand was true all over [t - end_s, t - start_s], within the run."""

    operand: Past
    start_s: float = 0.0
    end_s: float = math.inf


@dataclass(frozen=True)
class Previously(Node):
    """The operand as it was just before: not one sample ago, which would depend on how finely a run is sampled."""

    operand: Past


@dataclass(frozen=True)
class Since(Node):
    """`right` was true at some time, and `left` has been true ever since (after that time, up to now).

    It is enough that `left` becomes true at the very time at which `right` ceases to be.
    """

    left: Past
    right: Past


Past = BooleanName | On | Comparison | Not | And | Or | Rise | Fall | Once | Historically | Previously | Since


# --- responses ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Holds(Node):
    """State response: true as long as the antecedent is; an attempt is an episode of the antecedent."""

    condition: Past


@dataclass(frozen=True)
class Eventually(Node):
    """True somewhere in [trigger + start_s, trigger + end_s]; an attempt starts when the antecedent turns true."""

    condition: Past
    start_s: float
    end_s: float


@dataclass(frozen=True)
class AlwaysWithin(Node):
    """True all over [trigger + start_s, trigger + end_s]; an attempt starts when the antecedent turns true."""

    condition: Past
    start_s: float
    end_s: float


@dataclass(frozen=True)
class HoldsUntil(Node):
    """Weak until: true from the trigger until `release` is first true, or to the end of the run.

    `condition` need not hold any more at the instant of `release`.
    """

    condition: Past
    release: Past


Response = Holds | Eventually | AlwaysWithin | HoldsUntil


@dataclass(frozen=True)
class Formula(Node):
    """`always(antecedent -> response)`."""

    antecedent: Past
    response: Response
