"""`asyncio` in virtual time: Python's own event loop, with a selector that waits in the kernel.

asyncio keeps the running loop and task once a thread. All nodes are in one, so a node that blocks takes its own
away and puts them back when it continues: several nodes may have a loop, and a coroutine may block.
"""

from __future__ import annotations

import asyncio
import concurrent.futures
import heapq
import re
import selectors
import sys
from collections import deque
from collections.abc import Callable, Sequence
from contextvars import Context
from typing import Any, NoReturn, TypeVar, TypeVarTuple

from greenlet import GreenletExit

from pytest_hricdv._base.error_text import error_text
from pytest_hricdv.runtime.blocking_calls import ASYNCIO, HAS_TERMINALS, real_wait
from pytest_hricdv.runtime.kernel import US_PER_S, current_node
from pytest_hricdv.runtime.node_error import KernelError
from pytest_hricdv.runtime.source_location import error_line
from pytest_hricdv.runtime.virtual.clocks import monotonic
from pytest_hricdv.runtime.virtual.locks import WaitQueue
from pytest_hricdv.runtime.virtual.real_time import RealTimeError, node_to_wait
from pytest_hricdv.runtime.virtual.thread_pool import ThreadPoolExecutor

if HAS_TERMINALS:
    from pytest_hricdv.runtime.virtual.terminal import Terminal, terminal_of


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


__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all


T = TypeVar("T")
Ts = TypeVarTuple("Ts")

_NUMBERED = re.compile(r"Task-\d+")
_WAIT = getattr(getattr(asyncio.tasks, "_wait", None), "__code__", None)
"""The code object in which `asyncio.wait` waits."""


class VirtualEventLoop(asyncio.SelectorEventLoop):
    """An event loop whose time is that of the run."""

    def __init__(self) -> None:
        self._virtual_selector = VirtualSelector()
        self._pool: ThreadPoolExecutor | None = None
        self._failed: list[asyncio.Future[Any]] = []
        self._heeded: set[int] = set()
        super().__init__(self._virtual_selector)
        self._ready: deque[asyncio.Handle]  # of asyncio's loops: what is called at this instant
        self._scheduled: list[asyncio.TimerHandle]  # likewise, later: a heap

    def time(self) -> float:
        """The time of the run (s)."""
        return monotonic()

    def call_at(
        self,
        when: float,
        callback: Callable[[*Ts], object],
        *args: *Ts,
        context: Context | None = None,
    ) -> asyncio.TimerHandle:
        """Like that of asyncio's loops, which call at once what is due in less than the resolution of their clock."""
        now_s, when = self.time(), float(when + 0.0)  # the sum of a time and a float32 of numpy is a float32
        # Later than now is a microsecond later at least, or whoever asks for a time-out again would do so for ever.
        due_s = max(when, now_s + 1 / US_PER_S) if when > now_s else when
        return super().call_at(due_s, callback, *args, context=context)

    def call_later(
        self,
        delay: float,
        callback: Callable[[*Ts], object],
        *args: *Ts,
        context: Context | None = None,
    ) -> asyncio.TimerHandle:
        """Likewise."""
        return super().call_later(max(delay, 1 / US_PER_S) if delay > 0 else delay, callback, *args, context=context)

    def run_forever(self) -> None:
        """Like that of asyncio's loops."""
        node = node_to_wait(ASYNCIO, WHAT)
        node.leaving.append(leave_loop)
        try:
            super().run_forever()
        except (GreenletExit, KernelError):
            self.abandon_tasks()
            raise
        finally:
            node.leaving.remove(leave_loop)

    def abandon_tasks(self) -> None:
        """The run may be over at any moment, so waiting tasks are not reported."""
        waiting = [*asyncio.all_tasks(self)]
        self._tell_lost(waiting)
        for task in waiting:
            task._log_destroy_pending = False  # type: ignore[attr-defined]
            coroutine = task.get_coro()
            if coroutine is not None:
                coroutine.close()
            # It is over: whoever closes the loop has nothing to cancel.
            asyncio.tasks._unregister_task(task)
        # Callbacks that they cancelled in closing would continue in a closed coroutine, and asyncio would log the
        # error.
        self._ready.clear()

    def _process_events(self, event_list: Any) -> None:
        """Like that of asyncio's loops. Another one than the first of timers that are due together may go first."""
        super()._process_events(event_list)  # type: ignore[misc]
        node = current_node()
        if node is None or node.kernel.pick is None or len(self._scheduled) < 2:
            return
        first_s = min(timer.when() for timer in self._scheduled)
        due = [timer for timer in self._scheduled if timer.when() == first_s and not timer.cancelled()]
        number = node.kernel.choose(len(due)) if first_s <= self.time() else 0
        if number:
            due[number]._when = first_s - 0.1 / US_PER_S  # type: ignore[attr-defined]
            heapq.heapify(self._scheduled)

    def _make_self_pipe(self) -> None:
        """Make no pipe: a wait ends by `wake`, and garbage collection would close it before its loop, with a
        warning."""

    def _close_self_pipe(self) -> None:
        """Likewise."""

    def add_signal_handler(self, sig: int, callback: Callable[[*Ts], object], *args: *Ts) -> None:
        """Accepted, and never called: no signal comes in a run, and those of the process belong to the session."""
        self._check_signal(sig)  # type: ignore[attr-defined]
        self._heeded.add(sig)

    def remove_signal_handler(self, sig: int) -> bool:
        """Whether there was one."""
        was_heeded = sig in self._heeded
        self._heeded.discard(sig)
        return was_heeded

    def create_task(self, *arguments: Any, **options: Any) -> asyncio.Task[Any]:
        """Like that of asyncio's loops."""
        task: asyncio.Task[Any] = super().create_task(*arguments, **options)
        task.add_done_callback(self._keep_failed)
        if (node := current_node()) is not None and self.is_running():
            node.tasks += 1
        return task

    def default_exception_handler(self, context: dict[str, Any]) -> None:
        """Like that of asyncio's loops; what a callback raised, which continues without it, is lost in a run."""
        error, node = context.get("exception"), current_node()
        if node is not None and isinstance(error, Exception) and "handle" in context:
            node.kernel.lost_errors.append(
                f"a callback of asyncio raised {error_text(error)} at {error_line(error)}, and the event loop "
                "continued: catch it there, or let the loop's exception handler end the program"
            )
        super().default_exception_handler(context)

    def _keep_failed(self, task: asyncio.Future[Any]) -> None:
        if getattr(task, "_log_traceback", False):  # without taking the error: asyncio does not show this
            self._failed.append(task)

    def close(self) -> None:
        """Like that of asyncio's loops; unclaimed errors of tasks are reported now as lost."""
        if not self.is_closed():
            self._tell_lost([])
        super().close()

    def _tell_lost(self, waiting: Sequence[asyncio.Task[Any]]) -> None:
        """Report lost errors; asyncio would do so at garbage collection: at any moment, on standard error.

        Args:
            waiting: tasks that the end of the run has cut off: perhaps they would have taken an error.
        """
        for handle in [*self._ready]:  # an exit has ended the loop before it has called them
            if handle._callback == self._keep_failed:  # type: ignore[attr-defined]
                handle._run()
        failed, self._failed = self._failed, []
        node = current_node()
        for task in failed:
            if not getattr(task, "_log_traceback", False) or any(_may_take(other, task) for other in waiting):
                continue
            error = task.exception()  # asyncio says nothing more of it
            is_raised = isinstance(error, (SystemExit, KeyboardInterrupt))  # by the loop itself
            if node is not None and error is not None and not is_raised:
                node.kernel.lost_errors.append(
                    f"{_name(task)} raised {error_text(error)} at {error_line(error)}, and "
                    "nothing awaited it: await the task, or use asyncio.TaskGroup"
                )

    def call_soon_threadsafe(
        self, callback: Callable[[*Ts], object], *args: *Ts, context: Context | None = None
    ) -> asyncio.Handle:
        """Like that of asyncio's loops: other nodes may call it."""
        handle = super().call_soon(callback, *args, context=context)
        self._virtual_selector.wake()
        return handle

    def run_in_executor(
        self, executor: concurrent.futures.Executor | None, func: Callable[[*Ts], T], *args: *Ts
    ) -> asyncio.Future[T]:
        """Like that of asyncio's loops, with threads that are nodes."""
        if executor is None:
            self._pool = self._pool or ThreadPoolExecutor(thread_name_prefix="asyncio")
            executor = self._pool
        future = asyncio.wrap_future(executor.submit(func, *args), loop=self)
        future.add_done_callback(self._keep_failed)
        return future

    async def subprocess_exec(self, *_: Any, **__: Any) -> Any:
        """Refused: nothing of a run would ever tell that the process has ended."""
        _refuse("asyncio's subprocess")

    async def subprocess_shell(self, *_: Any, **__: Any) -> Any:
        """Likewise."""
        _refuse("asyncio's subprocess")

    async def sock_connect(self, *_: Any) -> None:
        """Likewise: no socket is looked at."""
        _refuse("asyncio's socket")

    async def sock_recv(self, *_: Any) -> bytes:
        """Likewise."""
        _refuse("asyncio's socket")

    def __del__(self, _warn: Any = None) -> None:
        # Whatever a run leaves open is closed without a warning: the run may end at any moment.
        if not self.is_closed() and not self.is_running():
            self.close()


def _refuse(what: str) -> NoReturn:
    node = node_to_wait(ASYNCIO, WHAT)
    kernel = node.kernel
    raise RealTimeError(real_wait(sys._getframe(1), f"node {node.name}", kernel.code, kernel.virtual, what))


def _may_take(waiting: asyncio.Task[Any], failed: asyncio.Future[Any]) -> bool:
    """Whether a task waits for several, of which one has failed: then it takes the error when all are done."""
    waiter = getattr(waiting, "_fut_waiter", None)
    if failed in (getattr(waiter, "_children", None) or ()):  # of asyncio.gather
        return True
    coroutine: Any = waiting.get_coro()
    while coroutine is not None:
        if getattr(coroutine, "cr_code", None) is _WAIT:
            return True
        coroutine = getattr(coroutine, "cr_await", None)
    return False


def _name(task: asyncio.Future[Any]) -> str:
    """The name given by its author: asyncio numbers the others, across all runs of a process."""
    if not isinstance(task, asyncio.Task):
        return "a call in asyncio's run_in_executor"
    name, coroutine = task.get_name(), task.get_coro()
    return f"a task of asyncio, {getattr(coroutine, '__qualname__', name) if _NUMBERED.fullmatch(name) else name},"


def leave_loop() -> Callable[[], None]:
    """Take away what asyncio keeps once a thread; returns what puts it back."""
    loop, hooks = asyncio._get_running_loop(), sys.get_asyncgen_hooks()
    if loop is None:
        return lambda: None
    task = asyncio.current_task(loop)
    if task is not None:
        asyncio.tasks._leave_task(loop, task)
    asyncio._set_running_loop(None)
    sys.set_asyncgen_hooks(None, None)

    def go_on() -> None:
        sys.set_asyncgen_hooks(*hooks)
        asyncio._set_running_loop(loop)
        if task is not None:
            asyncio.tasks._enter_task(loop, task)

    return go_on
