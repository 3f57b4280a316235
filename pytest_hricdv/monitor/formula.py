"""`Formula`, the formula of a requirement as data, `always(antecedent -> response)`; and the four kinds of responses.

The parser and `build` make formulas; `compile_formula` compiles them, and `monitor_of` chooses the monitor by the kind.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from pytest_hricdv.monitor.node import FormulaNode, PastFormula, window_text


@dataclass(frozen=True)
class Holds(FormulaNode):
    """State response: true while the antecedent is true; a trigger is an episode of the antecedent."""

    condition: PastFormula

    def __str__(self) -> str:
        return str(self.condition)


@dataclass(frozen=True)
class _ResponseInWindow(FormulaNode):
    """A response in [trigger + start_s, trigger + end_s]; a trigger starts when the antecedent becomes true."""

    WORD: ClassVar[str]
    condition: PastFormula
    start_s: float
    end_s: float

    def __str__(self) -> str:
        return f"{self.WORD}{window_text(self.start_s, self.end_s)}({self.condition})"


class Eventually(_ResponseInWindow):
    """True at some time in the window."""

    WORD = "eventually"


class AlwaysWithin(_ResponseInWindow):
    """True at all times in the window."""

    WORD = "always"


@dataclass(frozen=True)
class HoldsUntil(FormulaNode):
    """Weak until: true from the trigger until `release` is first true, or to the end of the run.

    At the instant of `release`, `condition` may already be false.
    """

    condition: PastFormula
    release: PastFormula

    def __str__(self) -> str:
        return f"always({self.condition}) until {self.release}"


Response = Holds | Eventually | AlwaysWithin | HoldsUntil


@dataclass(frozen=True)
class Formula(FormulaNode):
    """`always(antecedent -> response)`."""

    antecedent: PastFormula
    response: Response

    @property
    def conditions(self) -> tuple[PastFormula, ...]:
        """The antecedent, and the conditions of the response."""
        return self.children

    def __str__(self) -> str:
        return f"always({self.antecedent} -> {self.response})"
