"""`Delivery`, the timing of a middleware: draws the delay and loss of each message from the seed of the test.

`Bridge` calls `arrival` for each message, if the testbench declares delays, losses or reordering (`is_timed`).
Each message has its own random generator, seeded with its sender, name and number. Removing actions from a test, as
shrinking does, therefore does not change when the other messages arrive.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fnmatch import fnmatchcase

from pytest_hricdv._base.message import nearest
from pytest_hricdv.declarations.ros2 import Ros2, Ros2Error
from pytest_hricdv.generate.sampler import Uniform

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

_WILD = frozenset("*?[")  # the characters that make a name a pattern


@dataclass(frozen=True)
class Arrival:
    """When a message arrives: `delay_s` after it was sent, or never."""

    delay_s: float = 0.0
    is_lost: bool = False


def is_timed(declared: Ros2) -> bool:
    """Whether messages can be delayed, lost or reordered."""
    return bool(declared.delay_s or declared.drop or declared.reorder)


def check_timing(declared: Ros2) -> None:
    """Check the timing that a testbench declares.

    Raises:
        Ros2Error: a delay is negative or infinite, a share is not from 0 to 1, or reordered messages have no delay.
    """
    for pattern, delay_s in declared.delay_s.items():
        low_s, high_s = _bounds_s(delay_s)
        is_in_s = not isinstance(delay_s, Uniform) or delay_s.unit in ("", "s")
        if not (0.0 <= low_s <= high_s < math.inf and is_in_s):
            raise Ros2Error(
                f"ros2: delay_s of {pattern!r} is {delay_s}; expected seconds, such as 0.01 or Uniform(0.0, 0.05, 's')"
            )
    for pattern, share in declared.drop.items():
        if isinstance(share, bool) or not isinstance(share, int | float) or not 0.0 <= share <= 1.0:
            raise Ros2Error(f"ros2: drop of {pattern!r} is {share!r}; expected a share of messages, from 0 to 1")
    for pattern in declared.reorder:
        if not any(pattern == other or fnmatchcase(pattern, other) for other in declared.delay_s):
            raise Ros2Error(f"ros2: reorder of {pattern!r}: its messages have no delay; declare delay_s as a Uniform")


def _bounds_s(delay_s: Uniform | float) -> tuple[float, float]:
    if isinstance(delay_s, Uniform):
        return delay_s.low, delay_s.high
    is_number = isinstance(delay_s, int | float) and not isinstance(delay_s, bool)
    return (float(delay_s), float(delay_s)) if is_number else (math.nan, math.nan)


def timing_fields(declared: Ros2) -> dict[str, str]:
    """The timing for the record: pattern of names -> description."""
    words: dict[str, list[str]] = {}
    for pattern, delay_s in declared.delay_s.items():
        low_s, high_s = _bounds_s(delay_s)
        words.setdefault(pattern, []).append(f"delay {low_s:g}..{high_s:g} s")
    for pattern, share in declared.drop.items():
        words.setdefault(pattern, []).append(f"drop {share:g}")
    for pattern in declared.reorder:
        words.setdefault(pattern, []).append("reorder")
    return {pattern: ", ".join(parts) for pattern, parts in words.items()}


class Delivery:
    """Draws when each message arrives, by a declaration that `check_timing` has checked; `now_s` is simulated time."""

    def __init__(self, declared: Ros2, seed: int, now_s: Callable[[], float]) -> None:
        self._declared, self._seed, self._now_s = declared, seed, now_s
        self._numbers: dict[tuple[str, str, str], int] = {}
        self._last_s: dict[tuple[str, str, str], float] = {}
        """Sender, name and direction -> when the last message arrives."""

    def arrival(self, sender: str, full_name: str, direction: str, reliable: Callable[[], str]) -> Arrival:
        """When a message that is sent now will arrive.

        Args:
            reliable: describes the reliable connection; returns an empty string for one that may lose messages.

        Raises:
            Ros2Error: loss or reordering is declared for exactly this name, but the connection is reliable.
        """
        key = (sender, full_name, direction)
        number = self._numbers[key] = self._numbers.get(key, 0) + 1
        draw = random.Random(f"{self._seed} {sender} {full_name} {direction} {number}")
        name = full_name.partition("/_action/")[0]
        delay_pattern = _pattern(name, self._declared.delay_s)
        low_s, high_s = _bounds_s(self._declared.delay_s[delay_pattern]) if delay_pattern else (0.0, 0.0)
        delay_s = draw.uniform(low_s, high_s)
        is_lost = draw.random() < self._share(name, reliable)
        arrives_s = self._now_s() + delay_s
        if not self._may_overtake(name, reliable):
            arrives_s = max(arrives_s, self._last_s.get(key, 0.0))
            self._last_s[key] = arrives_s
        return Arrival(arrives_s - self._now_s(), is_lost)

    def _share(self, name: str, reliable: Callable[[], str]) -> float:
        """The share of messages that are lost."""
        pattern = _pattern(name, self._declared.drop)
        share = self._declared.drop.get(pattern, 0.0)
        is_kept = bool(share) and self._is_kept(name, pattern, reliable, "drop", "the middleware sends it again")
        return 0.0 if is_kept else share

    def _may_overtake(self, name: str, reliable: Callable[[], str]) -> bool:
        pattern = _pattern(name, self._declared.reorder)
        return bool(pattern) and not self._is_kept(name, pattern, reliable, "reorder", "the middleware keeps the order")

    @staticmethod
    def _is_kept(name: str, pattern: str, reliable: Callable[[], str], word: str, because: str) -> bool:
        """Whether the connection is reliable. Raises Ros2Error if the timing is declared for exactly this name."""
        between = reliable()
        if between and _WILD.isdisjoint(pattern):
            raise Ros2Error(
                f"ros2: {word} of {name}: {between}, so {because}; make one side best effort, or use the disturbances "
                "Drop and Delay, or delay_s"
            )
        return bool(between)

    def find_unused_names(self, full_names: Iterable[str]) -> list[str]:
        """A sentence on each name in the timing that is not in the graph."""
        existing = sorted({full_name.partition("/_action/")[0] for full_name in full_names})
        declared = self._declared
        names = dict.fromkeys([*declared.delay_s, *declared.drop, *declared.reorder])
        return [
            f"Ros2 has a timing for {name!r}, but no topic, service or action has this name{nearest(name, existing)}"
            for name in names
            if _WILD.isdisjoint(name) and name not in existing
        ]


def _pattern(name: str, patterns: Iterable[str]) -> str:
    """The pattern for a name: the name itself, or else the first one that matches; empty if none does."""
    every = list(patterns)
    return name if name in every else next((pattern for pattern in every if fnmatchcase(name, pattern)), "")
