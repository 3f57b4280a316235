"""The gripper, and what it holds."""

from __future__ import annotations

from house.flat import in_reach
from house.shapes import Point

CLOSES_S, OPENS_S = 2.5, 3.0
"""From wide open to closed, and back: as published."""

HELD_OPENING = 0.4
"""How far it is open around food or dishes, of 1: it cannot close farther (chosen: 3 cm of 8)."""

TAKEN_FROM = ("fridge", "table")
"""Where there is something to take: food in the fridge, dishes or food on the table. It does not run out (chosen)."""

LEFT_AT = ("table", "sink")
"""Where it may be left."""


class Gripper:
    """Opens and closes at constant speed; `carebot.ports.Gripper` without the messages.

    Closing takes something where the arm reaches it at the moment at which the fingers meet it. Opening lets it go at
    once, wherever that is.
    """

    def __init__(self) -> None:
        self.opening = 1.0
        self.holds = False
        self.dropped = False
        """Whether something was let go elsewhere than at table or sink, ever."""
        self.jammed = False
        """Whether the fingers stay as they are, whatever they are told."""
        self._goal = 1.0

    @property
    def moving(self) -> bool:
        """Whether the fingers move."""
        return self.opening != self._goal and not self.jammed

    def command(self, *, close: bool, at: Point) -> None:
        """Begin to close or open; `at`: where the robot is."""
        self._goal = (HELD_OPENING if self.holds else 0.0) if close else 1.0
        if not close and self.holds and not self.jammed:
            self.let_go(at)

    def step(self, duration_s: float, at: Point) -> None:
        """Let time pass."""
        if self.jammed:
            return
        if self._goal > self.opening:
            self.opening = min(self._goal, self.opening + duration_s / OPENS_S)
        elif self._goal < self.opening:
            before, self.opening = self.opening, max(self._goal, self.opening - duration_s / CLOSES_S)
            if before > HELD_OPENING >= self.opening and in_reach(at) in TAKEN_FROM:
                self.holds, self.opening, self._goal = True, HELD_OPENING, HELD_OPENING

    def let_go(self, at: Point) -> None:
        """What it holds falls, or is put down; it counts as dropped unless at table or sink."""
        self.holds = False
        self.dropped = self.dropped or in_reach(at) not in LEFT_AT

    def hand_over(self) -> None:
        """Somebody takes what it holds; the fingers stay where they are."""
        self.holds = False
