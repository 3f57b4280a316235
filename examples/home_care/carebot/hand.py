"""Closing and opening the gripper, and what is in it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from carebot.bus import Bus
from carebot.config import Config
from carebot.messages import Food, GripperCommand
from carebot.ports import Gripper

CLOSED, OPEN = 0.05, 0.95
"""As its state says, with room for its errors (chosen)."""


class GripperError(Exception):
    """The gripper did not do what it was told in its time."""


class Hand:
    """Closes around food or dishes, and lets go of them."""

    def __init__(self, gripper: Gripper, bus: Bus, config: Config) -> None:
        self._gripper = gripper
        self._bus = bus
        self._config = config
        self.holds = False

    async def grab(self) -> None:
        """Close it. Raises GripperError if it does not close: nothing is held then."""
        self._gripper.command(GripperCommand(close=True))
        await self._until(lambda opening: opening <= CLOSED, "close")
        self.holds = True
        self._bus.publish(Food(True))

    async def drop(self) -> None:
        """Open it. Raises GripperError if it does not open: what is in it is still there then."""
        self._gripper.command(GripperCommand(close=False))
        await self._until(lambda opening: opening >= OPEN, "open")
        self.holds = False
        self._bus.publish(Food(False))

    async def _until(self, done: Callable[[float], bool], deed: str) -> None:
        for _ in range(round(self._config.gripper_limit_s / self._config.period_s)):
            await asyncio.sleep(self._config.period_s)
            if done(self._gripper.state().opening):
                return
        raise GripperError(f"the gripper does not {deed}")
