"""`RequirementCandidate`: a requirement that may be suggested.

The templates in `bounds` and `order_templates` make candidates, with the helpers for numbers; `mining` ranks them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

Form = Literal["response", "precedence", "bound", "absence"]
"""The template of a candidate; see docs/patterns.md."""

MIN_SUPPORT = 3
"""Minimum number of times that something must have happened in the runs to be evidence for a candidate."""


@dataclass(frozen=True)
class RequirementCandidate:
    """A requirement that may be suggested.

    Args:
        form: its template.
        subjects: the topics and signals that it is about.
        support: how often it was triggered in the runs that it was mined from.
        observed: the extreme that a bound was made of, for people; empty for none.
        surprise: from 0 (it excludes hardly anything) to 1.
        of_state: whether it reads the state that the code under test reports.
    """

    form: Form
    title: str
    antecedent: str
    response: str
    subjects: frozenset[str]
    support: int
    observed: str = ""
    surprise: float = 0.5
    of_state: bool = False

    @property
    def formula(self) -> str:
        """The formula in the language of requirements."""
        return f"always({self.antecedent} -> {self.response})"

    @property
    def reaction(self) -> str:
        """What it asks for, without times."""
        return self.response.partition("](")[2] or self.response

    @property
    def worth(self) -> tuple[bool, bool, float]:
        """Its usefulness to people, whatever bugs violate it: a robot's reactions to messages come first."""
        return not self.of_state, self.antecedent.startswith("on("), self.surprise


def above(value: float, spread: float = 0.0) -> float:
    """A bound above an observed extreme: with a margin, rounded to two digits.

    The margin is half of the observed spread, but at least a tenth and at most a quarter of the value: what always
    takes the same time will hardly take longer, and of what varies the longest has not been observed yet.
    """
    margin = min(max(abs(spread) / 2, abs(value) / 10), abs(value) / 4)
    return round_up(value + margin)


def below(value: float, spread: float = 0.0) -> float:
    """A bound below an observed extreme, likewise."""
    return -above(-value, spread)


def round_up(value: float) -> float:
    """Round up to two digits.

    >>> round_up(12.31), round_up(0.0472), round_up(-151.0)
    (13.0, 0.048, -150.0)
    """
    if value == 0.0:
        return 0.0
    scale = 10.0 ** (math.floor(math.log10(abs(value))) - 1)
    return float(f"{math.ceil(value / scale - 1e-9) * scale:.6g}")


def is_quantity(member: str) -> bool:
    """Whether a number of a message has an order: a checksum of an array or a time stamp has none."""
    return not member.endswith(".crc") and "stamp." not in member


def number(value: float) -> str:
    """The short text of a number in a formula or a title."""
    return f"{value:.6g}"
