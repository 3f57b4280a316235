"""The robot: takes one order after the other, and goes to its charger when nobody wants anything."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine, Sequence
from math import hypot

from carebot.bus import Bus
from carebot.config import Config
from carebot.driving import ARRIVED_M, BlockedError, Driver
from carebot.flatmap import CHARGER, PLACES, FlatMap
from carebot.hand import GripperError, Hand
from carebot.messages import Completed, Docked, Idle, Refused, State
from carebot.orders import LATE, OrderDesk, Waiting
from carebot.ports import Base, Battery, Gripper
from carebot.tasks import CHARGING, DRIVING, DROP, ENDED, GRAB, HOME, OFF, PUT_DOWN_AT, READY, TASKS

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
        self._has_served = False

    async def run(self) -> None:
        """Work until somebody says that there are no more orders."""
        self._enter(READY)
        answering = asyncio.create_task(self._desk.serve())
        try:
            while (order := await self._following()).kind != ENDED:
                await self._serve(order)
        finally:
            answering.cancel()
        self._enter(OFF)

    async def _following(self) -> Waiting:
        """The next order. Without one for a while the robot is idle, and goes to its charger.

        With a low battery it goes there before the order, be it the last one: switched off, it could not any more.
        """
        while True:
            while not await self._is_ordered_in_time():
                self._bus.publish(Idle())
                await self._unless_ordered(self._go_home())
            if self._battery.level() < self._config.battery_low:
                await self._go_home()
                await self._charge()
            if self._desk.has_some:  # meanwhile it may have been given up
                return self._desk.take()

    async def _is_ordered_in_time(self) -> bool:
        faulty = self._config.faults.never_idle_first and not self._has_served
        hearing = asyncio.create_task(self._desk.some())
        await asyncio.wait((hearing,), timeout=None if faulty else self._config.idle_after_s)
        hearing.cancel()
        return self._desk.has_some

    async def _serve(self, order: Waiting) -> None:
        self._desk.busy = self._has_served = True
        await self._carry_out(order)
        if not self._hand.is_empty:
            await self._put_down()
        if not self._desk.has_some:
            await self._unless_ordered(self._go_home())
        self._desk.busy = False

    async def _unless_ordered(self, deed: Coroutine[None, None, None]) -> None:
        """Do something that the next order ends."""
        doing, hearing = asyncio.create_task(deed), asyncio.create_task(self._desk.some())
        await asyncio.wait((doing, hearing), return_when=asyncio.FIRST_COMPLETED)
        for task in (doing, hearing):
            task.cancel()
        await asyncio.wait((doing, hearing))
        if not doing.cancelled():
            await doing  # what it raised
        self._enter(READY)

    async def _carry_out(self, order: Waiting) -> None:
        doing = asyncio.create_task(self._go_through(TASKS[order.kind]))
        await asyncio.wait((doing,), timeout=order.due_s - asyncio.get_running_loop().time())
        doing.cancel()  # where it is not done in time
        await asyncio.wait((doing,))
        reason = _reason_against(doing)
        self._bus.publish(Refused(order.kind, reason) if reason else Completed(order.kind))
        self._enter(READY)

    async def _go_through(self, states: Sequence[str]) -> None:
        for state in states:
            await self._do(state)

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

    async def _go_home(self) -> None:
        """Go to the charger; where there is no way, stay."""
        try:
            await self._do(HOME)
        except BlockedError:
            self._enter(READY)
        else:
            self._bus.publish(Docked())

    async def _charge(self) -> None:
        """Stay at the charger until the battery is not low any more, or there are to be no more orders."""
        if self._is_to_charge():
            self._enter(CHARGING)
        while self._is_to_charge():
            await asyncio.sleep(CHARGE_CHECK_S)
        self._enter(READY)

    def _is_to_charge(self) -> bool:
        low = self._battery.level() < self._config.battery_enough
        return low and self._is_at_charger() and not self._desk.ends

    def _is_at_charger(self) -> bool:
        pose, (x, y) = self._base.pose(), PLACES[CHARGER]
        return hypot(pose.x - x, pose.y - y) <= 2 * ARRIVED_M

    def _enter(self, state: str) -> None:
        self._bus.publish(State(state))


def _reason_against(doing: asyncio.Task[None]) -> str:
    """Why an order was not carried out; empty where it was. Raises what is none of `PROBLEMS`."""
    try:
        doing.result()
    except PROBLEMS as problem:
        return str(problem)
    except asyncio.CancelledError:
        return LATE
    return ""
