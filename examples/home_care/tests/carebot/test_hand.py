"""The hand, with a gripper that does not do what it is told."""

from __future__ import annotations

import asyncio

import pytest
from carebot.bus import Bus
from carebot.config import Config
from carebot.hand import GripperError, Hand
from carebot.messages import GripperCommand, GripperState


class StuckGripper:
    """It holds something, and does not move; what it was told last is what it does once it comes free."""

    def __init__(self) -> None:
        self.told: list[GripperCommand] = []

    def command(self, command: GripperCommand) -> None:
        self.told.append(command)

    def state(self) -> GripperState:
        return GripperState(0.3)


def test_what_it_cannot_let_go_of_it_holds_on_to() -> None:
    gripper = StuckGripper()
    hand = Hand(gripper, Bus(), Config(gripper_limit_s=0.002, gripper_period_s=0.001))
    hand.is_empty = False
    with pytest.raises(GripperError):
        asyncio.run(hand.drop())
    assert gripper.told[-1] == GripperCommand(close=True)
    assert not hand.is_empty


def test_it_takes_nothing_with_a_gripper_that_was_not_open() -> None:
    """Jammed around what somebody has taken meanwhile, it is as far open as around something new."""
    hand = Hand(StuckGripper(), Bus(), Config(gripper_limit_s=0.002, gripper_period_s=0.001))
    with pytest.raises(GripperError, match="not open"):
        asyncio.run(hand.grab())
