"""Closing and opening the gripper, and what is in it."""

from __future__ import annotations

import asyncio

from carebot.bus import Bus
from carebot.config import Config
from carebot.messages import Food, GripperCommand
from carebot.ports import Gripper

CLOSED, HELD, OPEN = 0.05, 0.6, 0.95
"""As its state says, with room for its errors (chosen). Around food or dishes it closes to less than `HELD`, but not
as far as `CLOSED`."""


class GripperError(Exception):
    """The gripper did not do what it was told in its time."""


class Hand:
    """Closes around food or dishes, and lets go of them."""

    def __init__(self, gripper: Gripper, bus: Bus, config: Config) -> None:
        self._gripper = gripper
        self._bus = bus
        self._config = config
        self.is_empty = True
        """Whether it is open, and nothing can be in it."""

    async def grab(self) -> None:
        """Close it. Raises GripperError if it was not open, does not close, or nothing is in it then."""
        self.is_empty = False
        if self._gripper.state().opening < OPEN and not self._config.faults.trusts_gripper:
            raise GripperError("the gripper is not open")  # jammed around what somebody took, it would seem to hold it
        self._gripper.command(GripperCommand(close=True))
        opening, looks = await self._settled(), not self._config.faults.trusts_gripper
        if opening > HELD and looks:
            raise GripperError("the gripper does not close")
        if opening <= CLOSED and looks:
            raise GripperError("there is nothing to take")  # unreachable: what it takes there never runs out
        self._bus.publish(Food(True))

    async def drop(self) -> None:
        """Open it. Raises GripperError if it does not open: what is in it is held on to then."""
        self._gripper.command(GripperCommand(close=False))
        if await self._settled() < OPEN and not self._config.faults.trusts_gripper:
            # Else it would open wherever the robot is by then, once it comes free.
            self._gripper.command(GripperCommand(close=True))
            raise GripperError("the gripper does not open")
        self.is_empty = True
        self._bus.publish(Food(False))

    async def _settled(self) -> float:
        """How far it is open when it moves no more, or when its time is over."""
        before, opening = -1.0, self._gripper.state().opening
        looks = round(self._config.gripper_limit_s / self._config.gripper_period_s)
        while opening != before and looks:
            await asyncio.sleep(self._config.gripper_period_s)
            before, opening, looks = opening, self._gripper.state().opening, looks - 1
        return opening
