"""How the robot's coroutines hear the bus of a test, and are heard on it.

The carebot has a bus of its own, within its event loop. Whoever waits for a message of a test's bus blocks a node, so
a node of its own waits for those that the robot hears, and hands them to the loop, as the thread of a middleware does.
What the robot says is published by the loop's node itself, so that it counts as the robot's.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from functools import partial
from typing import Any

from carebot.bus import Bus
from carebot.messages import HEARD, SAID

from pytest_hricdv.testbench import Run

REST_OF_RUN_S = 10_000.0
"""Longer than any run: whoever hears waits until there is something, or the run is over."""

Program = Callable[[Bus], Coroutine[Any, Any, None]]


def spawn_robot(run: Run, program: Program) -> None:
    """Start the robot's program as a node, in which it is measured; the run ends when it ends.

    Args:
        run: the run.
        program: gets the robot's bus; awaited in a new event loop.
    """
    port = run.bus.port("robot")

    async def live() -> None:
        loop, bus = asyncio.get_running_loop(), Bus()
        for kind in HEARD:
            run.kernel.spawn(f"robot hears {kind.__name__}", partial(hear, kind, loop, bus))
        bus.listen(lambda message: port.publish(message) if isinstance(message, SAID) else None)
        await program(bus)

    def hear(kind: type[object], loop: asyncio.AbstractEventLoop, bus: Bus) -> None:
        subscription = port.subscribe(kind)
        while not loop.is_closed():
            message = subscription.wait(REST_OF_RUN_S)
            if message is not None and not loop.is_closed():
                loop.call_soon_threadsafe(bus.publish, message)

    def robot() -> None:
        asyncio.run(live())
        run.kernel.stop("the robot has ended its work")

    run.kernel.spawn("robot", run.measured(robot))
