"""A requirement that may be suggested."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Literal

Form = Literal["response", "precedence", "bound", "at event", "relation", "absence"]
"""What it is of the patterns: see docs/patterns.md."""

STATE_DISCOUNT, EDGE_DISCOUNT = 0.4, 0.2
"""What is said of the code's own state, or of a number that leaves 0, is worth less than the world (chosen)."""


SIGNALS_DISCOUNT = 0.35
"""What only signals say is often how the world works, and not what the robot has to do (chosen)."""

MESSAGE_BONUS = 0.15
"""What is asked for at a message is easier to judge for people than at a change of a signal (chosen)."""

_WEIGHTS = {"relation": 1.0, "absence": 0.9, "response": 0.8, "at event": 0.8, "precedence": 0.7, "bound": 0.6}
"""What a form is worth to people who read many (chosen)."""

_OF_MESSAGES = re.compile(r"\bon\(|\brise\(!?\w+\.\w")
"""A message that comes, or that says something else than before."""


@dataclass(frozen=True)
class Candidate:
    """A requirement that may be suggested.

    Args:
        form: of it.
        title: in one sentence.
        antecedent: of the formula.
        response: of the formula.
        subjects: the topics and signals that it is about.
        support: how often it was triggered in the runs that it was learnt of.
        observed: the extreme that a bound was made of, for people; empty for none.
        surprise: from 0 (it says hardly anything) to 1.
        of_state: it reads the state that the code under test tells.
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
        """Of the language of requirements."""
        return f"always({self.antecedent} -> {self.response})"

    @property
    def reaction(self) -> str:
        """What it asks for, whenever: the response without its times; of conditions at an event, all of them."""
        return self.response.partition("](")[2] or self.response

    @property
    def worth(self) -> float:
        """How much it says by itself, whatever faults it notices."""
        # A bound is about a number, and most are of signals.
        edge = self.form != "bound" and ("> 0" in self.antecedent or "> 0" in self.response)
        discount = STATE_DISCOUNT * self.of_state + EDGE_DISCOUNT * edge
        discount += SIGNALS_DISCOUNT * (self.form != "bound" and _OF_MESSAGES.search(self.formula) is None)
        discount -= MESSAGE_BONUS * self.antecedent.startswith("on(")
        return _WEIGHTS[self.form] * self.surprise - discount


LEAST_SUPPORT = 3
"""What happened less often says nothing (chosen)."""


def above(value: float, spread: float = 0.0) -> float:
    """A bound above an observed extreme: with a margin, and of two digits.

    The margin is half of the spread of what was observed, but at least a tenth and at most a quarter of it: what
    always takes the same time will hardly take longer, and of what varies the longest was not seen yet (chosen).
    """
    margin = min(max(abs(spread) / 2, abs(value) / 10), abs(value) / 4)
    return rounded(value + margin, up=True)


def below(value: float, spread: float = 0.0) -> float:
    """A bound below an observed extreme, likewise."""
    return -above(-value, spread)


def rounded(value: float, *, up: bool) -> float:
    """To two digits, away from the value.

    >>> rounded(12.31, up=True), rounded(0.0472, up=False), rounded(-151.0, up=True)
    (13.0, 0.047, -150.0)
    """
    if value == 0.0:
        return 0.0
    scale = 10.0 ** (math.floor(math.log10(abs(value))) - 1)
    exact = value / scale
    whole = math.ceil(exact - 1e-9) if up else math.floor(exact + 1e-9)
    return float(f"{whole * scale:.6g}")


CHECKSUM = ".crc"
"""What the name of the checksum of an array ends in (see `pytest_hricdv.extra.ros2.messages`)."""


def is_quantity(member: str) -> bool:
    """Whether a number of a message can be compared with others: a checksum of an array, or a time stamp, cannot."""
    return not member.endswith(CHECKSUM) and "stamp." not in member


def number(value: float) -> str:
    """Of a formula or a title, short."""
    return f"{value:.6g}"


def between(low: float, high: float) -> float:
    """The shortest number between two."""
    middle = (low + high) / 2
    for digits in range(1, 17):
        value = float(f"{middle:.{digits}g}")
        if low < value < high:
            return value
    return middle
