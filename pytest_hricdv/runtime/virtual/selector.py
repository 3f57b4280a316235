"""The selector of an asyncio event loop, which waits in the kernel instead of the operating system."""

from __future__ import annotations

import selectors
from typing import Any

from pytest_hricdv.runtime.blocking_calls import ASYNCIO, HAS_TERMINALS
from pytest_hricdv.runtime.kernel import current_node
from pytest_hricdv.runtime.virtual.locks import WaitQueue
from pytest_hricdv.runtime.virtual.real_time import node_to_wait

if HAS_TERMINALS:
    from pytest_hricdv.runtime.virtual.terminal import Terminal, terminal_of

__tracebackhide__ = True

WHAT = "the event loop of asyncio"


class VirtualSelector(selectors.SelectSelector):
    """Waits for time to pass, for `wake`, and for keys at the terminal of its node.

    It looks at no socket: nothing outside of the run may have an effect.
    """

    def __init__(self) -> None:
        super().__init__()
        self._waiting = WaitQueue(ASYNCIO, WHAT)

    def select(self, timeout: float | None = None) -> list[Any]:
        terminal = self._terminal()
        if (timeout is not None and timeout <= 0) or (terminal is not None and terminal.is_readable):
            node_to_wait(ASYNCIO, WHAT).kernel.count_poll()
        elif terminal is None:
            self._waiting.wait(timeout)
        else:
            with terminal.notify(self.wake):
                self._waiting.wait(timeout)
        is_ready = terminal is not None and terminal.is_readable
        return [(self.get_map()[terminal.fd], selectors.EVENT_READ)] if terminal is not None and is_ready else []

    def _terminal(self) -> Terminal | None:
        """The terminal of the running node, if somebody has asked for its keys (`loop.add_reader`)."""
        node = current_node()
        terminal = terminal_of(node) if node is not None and HAS_TERMINALS else None
        return terminal if terminal is not None and terminal.fd in self.get_map() else None

    def wake(self) -> None:
        self._waiting.wake()
