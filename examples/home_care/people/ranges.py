"""The commands of a test and their ranges: as published where there are any, chosen where not.

Orders without another word are those of the published tests: after one, the person waits for as long as the robot
should need. `ask fridge` is the same order, after which the person goes on at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from random import Random

from pytest_hricdv.testbench import Concretization, Sampler, Uniform


@dataclass(frozen=True)
class WholeSeconds(Sampler):
    """A whole number of seconds, each from `low` to `high` equally likely: how the published experiment drew them."""

    low: int
    high: int
    unit: str = "s"

    def sample(self, rng: Random) -> float:
        """A number of seconds."""
        return float(rng.randint(self.low, self.high))

    def corners(self) -> tuple[float, ...]:
        """The least and the greatest."""
        return (float(self.low), float(self.high))

    def simple_values(self) -> tuple[float, ...]:
        """The middle, then the ends."""
        return (float((self.low + self.high) // 2), *self.corners())

    def contains(self, value: float) -> bool:
        """Whether it is one of them."""
        return self.low <= value <= self.high and value == int(value)

    def __str__(self) -> str:
        return f"whole seconds from {self.low} to {self.high}"


KNOWN = ("fridge", "sink", "feed", "clean")
"""What the robot can do."""

UNKNOWN = ("whatever", "chase", "opendoor", "recharge")
"""What is asked in the published tests besides; the robot cannot do it."""

ENDED = "ended"
"""No more orders."""

PUBLISHED_S: Mapping[str, WholeSeconds] = {
    "fridge": WholeSeconds(90, 120),
    "sink": WholeSeconds(90, 120),
    "feed": WholeSeconds(120, 150),
    "clean": WholeSeconds(140, 170),
    **dict.fromkeys(UNKNOWN, WholeSeconds(10, 20)),
}
"""How long the person waits after an order (published)."""

PLACES = ("table", "tv", "doorway", "fridge", "kitchen", "sink", "charger")
"""Where the person may walk to; where they are, the world says."""

# Chosen: those of people between slow and normal indoors; fast enough to come before the robot, at 0.25 m/s.
_WALKS = {"speed_m_s": Uniform(0.6, 1.2, "m/s")}
_MOMENT = {"wait_s": WholeSeconds(1, 10)}  # chosen: it is an order given while the robot is at another one

COMMANDS: Mapping[str, Mapping[str, Sampler]] = {
    **{order: {"wait_s": wait_s} for order, wait_s in PUBLISHED_S.items()},
    **{f"ask {order}": _MOMENT for order in PUBLISHED_S},
    **{f"walk {place}": {**_WALKS, "wait_s": WholeSeconds(0, 15)} for place in PLACES},
    "sit": _WALKS,
    "call_dog": {},
    # Chosen: as long as any order may take, and longer than the 30 s after which the robot is idle.
    "wait": {"wait_s": WholeSeconds(100, 170)},
    "rest": {"wait_s": WholeSeconds(60, 100)},
    ENDED: _MOMENT,
}

RUN: Mapping[str, Sampler] = {
    # Published: about 5 s after the nodes start.
    "first_order_s": Uniform(4.5, 5.5, "s"),
}

CONCRETIZATION = Concretization(COMMANDS, RUN)
