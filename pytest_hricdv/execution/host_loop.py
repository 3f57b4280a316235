"""The event loop of a test function that is a coroutine, which asyncio takes for that of all nodes of a run."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def leave_host_loop() -> Iterator[None]:
    """Take away the loop that runs the test function, so that the code under test may have loops of its own."""
    asyncio = sys.modules.get("asyncio")
    if asyncio is None or asyncio._get_running_loop() is None:
        yield
        return
    from pytest_hricdv.runtime.virtual.event_loop import leave_loop

    go_on = leave_loop()
    try:
        yield
    finally:
        go_on()
