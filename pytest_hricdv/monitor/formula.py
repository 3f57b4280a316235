"""The formula of a requirement as data: `always(antecedent -> response)`. The names of all nodes are here.

`str(formula)` is its text in the requirement language, which is parsed to an equal formula. Times are in seconds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from pytest_hricdv.monitor.node import Node, window_text
from pytest_hricdv.monitor.past_formula import (
    And,
    Arithmetic,
    ArithmeticOperator,
    BooleanName,
    Comparison,
    Count,
    Equality,
    Fall,
    FloatName,
    Historically,
    Negative,
    Not,
    Number,
    On,
    Once,
    Or,
    PastFormula,
    Previously,
    Relation,
    Rise,
    Since,
    Term,
    Text,
    TextComparison,
    TextName,
    TextTerm,
    TimeBetween,
    TimeSince,
)

__all__ = [
    "AlwaysWithin",
    "And",
    "Arithmetic",
    "ArithmeticOperator",
    "BooleanName",
    "Comparison",
    "Count",
    "Equality",
    "Eventually",
    "Fall",
    "FloatName",
    "Formula",
    "Historically",
    "Holds",
    "HoldsUntil",
    "Negative",
    "Not",
    "Number",
    "On",
    "Once",
    "Or",
    "PastFormula",
    "Previously",
    "Relation",
    "Response",
    "Rise",
    "Since",
    "Term",
    "Text",
    "TextComparison",
    "TextName",
    "TextTerm",
    "TimeBetween",
    "TimeSince",
]

# --- responses: what has to follow when the antecedent is true


@dataclass(frozen=True)
class Holds(Node):
    """State response: true while the antecedent is true; a trigger is an episode of the antecedent."""

    condition: PastFormula

    def __str__(self) -> str:
        return str(self.condition)


@dataclass(frozen=True)
class _WindowedResponse(Node):
    """A response in [trigger + start_s, trigger + end_s]; a trigger starts when the antecedent becomes true."""

    WORD: ClassVar[str]
    condition: PastFormula
    start_s: float
    end_s: float

    def __str__(self) -> str:
        return f"{self.WORD}{window_text(self.start_s, self.end_s)}({self.condition})"


class Eventually(_WindowedResponse):
    """True at some time in the window."""

    WORD = "eventually"


class AlwaysWithin(_WindowedResponse):
    """True at all times in the window."""

    WORD = "always"


@dataclass(frozen=True)
class HoldsUntil(Node):
    """Weak until: true from the trigger until `release` is first true, or to the end of the run.

    At the instant of `release`, `condition` may already be false.
    """

    condition: PastFormula
    release: PastFormula

    def __str__(self) -> str:
        return f"always({self.condition}) until {self.release}"


Response = Holds | Eventually | AlwaysWithin | HoldsUntil


@dataclass(frozen=True)
class Formula(Node):
    """`always(antecedent -> response)`."""

    antecedent: PastFormula
    response: Response

    def __str__(self) -> str:
        return f"always({self.antecedent} -> {self.response})"
