"""Functions of `asyncio` that make and run event loops, in virtual time; in a run, they take the place of asyncio's."""

from __future__ import annotations

import asyncio
import concurrent.futures
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import Any

from pytest_hricdv.runtime.blocking_calls import ASYNCIO
from pytest_hricdv.runtime.kernel import current_node
from pytest_hricdv.runtime.node_error import KernelError
from pytest_hricdv.runtime.virtual.event_loop import WHAT, VirtualEventLoop
from pytest_hricdv.runtime.virtual.real_time import node_to_wait
from pytest_hricdv.runtime.virtual.references import stand_in
from pytest_hricdv.runtime.virtual.thread_pool import Future

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

_NEW_EVENT_LOOP = asyncio.new_event_loop


_LOOP = "event loop"


def new_event_loop() -> asyncio.AbstractEventLoop:
    """Like that of asyncio."""
    if current_node() is None:
        return _NEW_EVENT_LOOP()
    node_to_wait(ASYNCIO, WHAT)
    return VirtualEventLoop()


def set_event_loop(loop: asyncio.AbstractEventLoop | None) -> None:
    """Like that of asyncio, for the running node."""
    node = current_node()
    if node is None:
        asyncio.set_event_loop(loop)
    else:
        node.own[_LOOP] = loop


def get_event_loop() -> asyncio.AbstractEventLoop:
    """Like that of asyncio: the running loop, else that of the node, which has a new one if there is none."""
    node, running = current_node(), asyncio._get_running_loop()
    if node is None or running is not None:
        return asyncio.get_event_loop()
    loop = node.own.get(_LOOP)
    if not isinstance(loop, asyncio.AbstractEventLoop):
        loop = node.own[_LOOP] = new_event_loop()
    return loop


def ensure_future(coro_or_future: Any, *, loop: Any = None) -> asyncio.Future[Any]:
    """Like that of asyncio; where no loop runs, in the loop of the node."""
    if loop is None and current_node() is not None and not asyncio.isfuture(coro_or_future):
        loop = get_event_loop()
    future: asyncio.Future[Any] = asyncio.ensure_future(coro_or_future, loop=loop)
    return future


class VirtualRunner(asyncio.Runner):  # type: ignore[misc]  # final, and still the one that there is to reuse
    """Like that of asyncio. Ctrl+C ends the session, as ever, instead of the coroutine."""

    def __init__(self, *, debug: bool | None = None, loop_factory: Callable[[], Any] | None = None) -> None:
        super().__init__(debug=debug, loop_factory=loop_factory or new_event_loop)

    def run(self, coro: Coroutine[Any, Any, Any], *, context: Any = None) -> Any:
        """Like that of asyncio, which also says what else is not a coroutine."""
        if current_node() is None or not asyncio.iscoroutine(coro):
            return super().run(coro, context=context)
        with _close_if_refused(coro):
            loop = self.get_loop()
        return loop.run_until_complete(loop.create_task(coro, context=context))


def run(main: Coroutine[Any, Any, Any], *, debug: bool | None = None, loop_factory: Any = None) -> Any:
    """Like that of asyncio."""
    if asyncio._get_running_loop() is not None:
        raise RuntimeError("asyncio.run() cannot be called from a running event loop")
    with _close_if_refused(main), VirtualRunner(debug=debug, loop_factory=loop_factory) as runner:
        return runner.run(main)


@contextmanager
def _close_if_refused(coro: Coroutine[Any, Any, Any]) -> Iterator[None]:
    """Nobody will await a coroutine whose loop is refused: without this Python would warn of it, at any later time."""
    try:
        yield
    except KernelError:
        coro.close()
        raise


def run_coroutine_threadsafe(coro: Any, loop: Any) -> concurrent.futures.Future[Any]:
    """Like that of asyncio, with a future that waits in virtual time."""
    if not isinstance(loop, VirtualEventLoop):
        return asyncio.run_coroutine_threadsafe(coro, loop)
    future = Future()

    def begin() -> None:
        try:
            asyncio.futures._chain_future(asyncio.ensure_future(coro, loop=loop), future)  # type: ignore[attr-defined]
        except Exception as error:
            if future.set_running_or_notify_cancel():
                future.set_exception(error)
            raise

    loop.call_soon_threadsafe(begin)
    return future


_NAMES: dict[str, Any] = {
    "run": run,
    "Runner": VirtualRunner,
    "new_event_loop": new_event_loop,
    "get_event_loop": get_event_loop,
    "set_event_loop": set_event_loop,
    "ensure_future": ensure_future,
    "run_coroutine_threadsafe": run_coroutine_threadsafe,
    "SelectorEventLoop": new_event_loop,
}


MODULES: tuple[ModuleType, ...] = (stand_in(asyncio, _NAMES),)
"""The modules that the code under test sees."""
