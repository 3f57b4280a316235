"""The world: an arm that moves, and a person near it. Replace it with your simulator.

The kernel calls `advance` while all of the robot's code waits, and then `observe`.
"""

from __future__ import annotations

from pytest_hricdv.runtime import Recorder

STEP_US = 20_000


class World:
    """The world of a run, and the arm in it."""

    def __init__(self, recorder: Recorder) -> None:
        self._recorder = recorder
        self._time_us = 0
        self._moves = False
        self.near = False
        self.observe()

    def advance(self, target_us: int) -> int:
        """Make one step, but not beyond `target_us` (us); returns the time reached."""
        self._time_us = min(self._time_us + STEP_US, target_us)
        return self._time_us

    def observe(self) -> None:
        """Record the signals that requirements read."""
        self._recorder.signal(self._time_us / 1e6, "arm_moves", self._moves)
        self._recorder.signal(self._time_us / 1e6, "person_near", self.near)

    def move(self, on: bool) -> None:
        """Move the arm, or let it rest."""
        self._moves = on

    def person_is_near(self) -> bool:
        """What the sensor says."""
        return self.near
