"""The robot: takes one order after the other, and goes to its charger when nobody wants anything."""

from __future__ import annotations

import asyncio
from math import hypot

from carebot.bus import Bus
from carebot.config import Config
from carebot.driving import ARRIVED_M, BlockedError, Driver
from carebot.flatmap import CHARGER, PLACES, FlatMap
from carebot.hand import GripperError, Hand
from carebot.messages import Completed, Docked, Idle, Refused, State
from carebot.orders import OrderDesk
from carebot.ports import Base, Battery, Gripper
from carebot.tasks import CHARGING, DRIVING, DROP, ENDED, GRAB, PUT_DOWN_AT, READY, TASKS

CHARGE_CHECK_S = 5.0
"""How often it looks how full the battery is (chosen)."""

PROBLEMS = (BlockedError, GripperError)


class Carebot:
    """The home-care robot.

    Args:
        bus: on which it hears orders and says what it does.
        base: its wheels, laser and localization.
        gripper: its gripper.
        battery: its battery.
        config: its settings.
    """

    def __init__(self, bus: Bus, base: Base, gripper: Gripper, battery: Battery, config: Config) -> None:
        self._bus = bus
        self._base = base
        self._battery = battery
        self._config = config
        self._desk = OrderDesk(bus, config)
        self._driver = Driver(base, FlatMap(), config)
        self._hand = Hand(gripper, bus, config)

    async def run(self) -> None:
        """Work until somebody says that there are no more orders."""
        self._enter(READY)
        desk = asyncio.create_task(self._desk.serve())
        try:
            while (order := await self._desk.following()) != ENDED:
                if order is None:
                    self._bus.publish(Idle())
                    await self._rest()
                else:
                    await self._serve(order)
            self._bus.publish(Completed(ENDED))
        finally:
            desk.cancel()

    async def _serve(self, order: str) -> None:
        self._desk.busy = True
        await self._carry_out(order)
        if self._hand.holds:
            await self._put_down()
        if self._battery.level() < self._config.battery_low:
            await self._rest()
        self._desk.busy = False

    async def _carry_out(self, order: str) -> None:
        try:
            for state in TASKS[order]:
                await self._do(state)
        except PROBLEMS as problem:
            self._bus.publish(Refused(order, str(problem)))
        else:
            self._bus.publish(Completed(order))
        self._enter(READY)

    async def _do(self, state: str) -> None:
        self._enter(state)
        if state == GRAB:
            await self._hand.grab()
        elif state == DROP:
            await self._hand.drop()
        else:
            await self._driver.drive_to(PLACES[DRIVING[state]])

    async def _put_down(self) -> None:
        """Take what is in the hand to the nearest thing to its place; where there is no way, it is kept."""
        for place in PUT_DOWN_AT:
            try:
                await self._do(place)
                await self._do(DROP)
            except PROBLEMS:
                continue
            break
        self._enter(READY)

    async def _rest(self) -> None:
        """Go to the charger, and stay there until the battery is not low any more."""
        try:
            await self._do("Recharge")
        except BlockedError:
            self._enter(READY)
            return
        self._bus.publish(Docked())
        while self._battery.level() < self._config.battery_enough and self._is_at_charger():
            self._enter(CHARGING)
            await asyncio.sleep(CHARGE_CHECK_S)
        self._enter(READY)

    def _is_at_charger(self) -> bool:
        pose, (x, y) = self._base.pose(), PLACES[CHARGER]
        return hypot(pose.x - x, pose.y - y) <= 2 * ARRIVED_M

    def _enter(self, state: str) -> None:
        self._bus.publish(State(state))
