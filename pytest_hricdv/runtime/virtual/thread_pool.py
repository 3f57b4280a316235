"""The thread pool of `concurrent.futures` in virtual time, with Python's own futures on virtual conditions."""

from __future__ import annotations

import concurrent.futures as real_futures
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from typing import Any

from pytest_hricdv._base.error_text import error_text
from pytest_hricdv.runtime.kernel import current_node
from pytest_hricdv.runtime.source_location import UNKNOWN, error_line, place_of
from pytest_hricdv.runtime.virtual import locks
from pytest_hricdv.runtime.virtual.clocks import monotonic
from pytest_hricdv.runtime.virtual.real_time import ProhibitedError
from pytest_hricdv.runtime.virtual.references import stand_in
from pytest_hricdv.runtime.virtual.threads import Thread, current_thread

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all


class Future(real_futures.Future[Any]):
    """Like `concurrent.futures.Future`, which waits in its condition only."""

    def __init__(self) -> None:
        super().__init__()
        self._condition: Any = locks.Condition()
        self._is_taken = False
        self.begun_at = ""
        """The line that gave the call to the pool."""

    def result(self, timeout: float | None = None) -> Any:
        """Like that of `concurrent.futures.Future`."""
        self._is_taken = True
        return super().result(timeout)

    def exception(self, timeout: float | None = None) -> BaseException | None:
        """Like that of `concurrent.futures.Future`."""
        self._is_taken = True
        return super().exception(timeout)

    def add_done_callback(self, fn: Callable[[Any], object]) -> None:
        """Like that of `concurrent.futures.Future`, which logs what a callback raises; a run counts it as lost."""

        def call(future: real_futures.Future[Any]) -> object:
            try:
                return fn(future)
            except Exception as error:
                if (node := current_node()) is not None:
                    node.kernel.lost_errors.append(
                        f"a callback of a future raised {error_text(error)} at {error_line(error)}, and the thread "
                        "continued: catch it there"
                    )
                raise

        super().add_done_callback(call)

    def describe_unclaimed(self) -> str:
        """A sentence about an unclaimed error at the end of the run; empty if there is none."""
        error: BaseException | None = self._exception  # without waiting for it
        if self._is_taken or error is None:
            return ""
        place = error_line(error)
        return (
            f"a call in a ThreadPoolExecutor raised {error_text(error)} at "
            f"{self.begun_at if place == UNKNOWN else place}, and nothing asked its "
            "future: call result() or exception()"
        )


WORK = "work"
"""Key in `Node.own` for the present work of a pool's node: the future of a call."""


class ThreadPoolExecutor(real_futures.Executor):
    """Like `concurrent.futures.ThreadPoolExecutor`."""

    def __init__(
        self,
        max_workers: int | None = None,
        thread_name_prefix: str = "",
        initializer: Callable[..., object] | None = None,
        initargs: tuple[Any, ...] = (),
    ) -> None:
        if max_workers is not None and max_workers <= 0:
            raise ValueError("max_workers must be greater than 0")
        # As many as on a large machine: a run must not depend on the number of processors.
        self._max_workers = max_workers or 32
        self._prefix = thread_name_prefix or "ThreadPoolExecutor"
        self._initialize: Callable[[], object] = lambda: initializer(*initargs) if initializer is not None else None
        self._work: list[tuple[Future, Callable[[], Any]]] = []
        self._idle = 0
        self._threads: list[Thread] = []
        self._changed = locks.Condition()
        self._is_shut_down = False
        self._kernel: object = None

    def _begin_in(self, kernel: object) -> None:
        """Forget the threads of another run: a cache or a singleton may have kept the pool since."""
        if kernel is not self._kernel:
            self._kernel, self._idle, self._changed = kernel, 0, locks.Condition()
            self._work.clear()
            self._threads.clear()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future:
        """Like that of `concurrent.futures.Executor`."""
        if self._is_shut_down:
            raise RuntimeError("cannot schedule new futures after shutdown")
        if (node := current_node()) is not None:
            self._begin_in(node.kernel)
        future = Future()
        future.begun_at = place_of(sys._getframe(1))
        self._work.append((future, lambda: fn(*args, **kwargs)))
        if self._idle < len(self._work) and len(self._threads) < self._max_workers:
            thread = Thread(target=self._serve, name=f"{self._prefix}_{len(self._threads)}", daemon=True)
            self._threads.append(thread)
            thread.start()
        with self._changed:
            self._changed.notify()
        return future

    def _serve(self) -> None:
        self._initialize()
        while True:
            with self._changed:
                self._idle += 1
                self._changed.wait_for(lambda: self._work or self._is_shut_down)
                self._idle -= 1
                if not self._work:
                    return
                future, call = self._work.pop(0)
            current_thread().begun_at = future.begun_at
            if (node := current_node()) is not None:
                node.own[WORK] = future  # a pool gives each call to a thread that is free: which one says nothing
            if future.set_running_or_notify_cancel():
                try:
                    result = call()
                except Exception as error:
                    node = current_node()
                    if node is not None:
                        node.kernel.unclaimed.append(future.describe_unclaimed)
                    future.set_exception(error)
                else:
                    future.set_result(result)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Like that of `concurrent.futures.Executor`."""
        self._is_shut_down = True
        while cancel_futures and self._work:
            future, _ = self._work.pop()
            future.cancel()
            future.set_running_or_notify_cancel()
        with self._changed:
            self._changed.notify_all()
        for thread in self._threads if wait else ():
            thread.join()


def as_completed(fs: Iterable[Any], timeout: float | None = None) -> Iterator[Any]:
    """Like `concurrent.futures.as_completed`; futures that are done at the same instant come in the order of `fs`."""
    end_s = None if timeout is None else monotonic() + timeout
    left = list(dict.fromkeys(fs))
    count = len(left)
    while left:
        done = [future for future in left if future.done()]
        if not done and not _wait_for_one(left, None if end_s is None else end_s - monotonic()):
            raise TimeoutError(f"{len(left)} (of {count}) futures unfinished")
        yield from done
        left = [future for future in left if future not in done]


def wait(fs: Iterable[Any], timeout: float | None = None, return_when: str = real_futures.ALL_COMPLETED) -> Any:
    """Like `concurrent.futures.wait`."""
    every = list(dict.fromkeys(fs))
    end_s = None if timeout is None else monotonic() + timeout
    while left := [future for future in every if not future.done()]:
        finished = [future for future in every if future.done()]
        if finished and return_when == real_futures.FIRST_COMPLETED:
            break
        if return_when == real_futures.FIRST_EXCEPTION and any(
            not future.cancelled() and future.exception() is not None for future in finished
        ):
            break
        if not _wait_for_one(left, None if end_s is None else end_s - monotonic()):
            break
    done = {future for future in every if future.done()}
    return _DoneAndNotDone(done, set(every) - done)


_DoneAndNotDone: Any = type(real_futures.wait([]))


def _wait_for_one(futures: list[Any], timeout_s: float | None) -> bool:
    """Wait until one of them is done; whether one was in time."""
    if timeout_s is not None and timeout_s <= 0:
        return False
    one_done = locks.Event()

    def notice(_: object) -> None:
        one_done.set()

    for future in futures:
        real_futures.Future.add_done_callback(future, notice)
    try:
        return one_done.wait(timeout_s)
    finally:
        for future in futures:  # who waits again and again for the same future would leave one each time
            with suppress(ValueError):
                future._done_callbacks.remove(notice)


class ProcessPoolExecutor:
    """Like `concurrent.futures.ProcessPoolExecutor`, outside of nodes."""

    def __new__(cls, *arguments: Any, **named: Any) -> Any:
        """The real one. Raises ProhibitedError in a node: what another process does takes no simulated time."""
        node = current_node()
        if node is not None:
            raise ProhibitedError(
                f"{place_of(sys._getframe(1))}: ProcessPoolExecutor in node {node.name}: other processes have no "
                "virtual time: let the code have a ThreadPoolExecutor in tests"
            )
        return real_futures.ProcessPoolExecutor(*arguments, **named)


_NAMES = {
    "ThreadPoolExecutor": ThreadPoolExecutor,
    "ProcessPoolExecutor": ProcessPoolExecutor,
    "Future": Future,
    "as_completed": as_completed,
    "wait": wait,
}

MODULES = (stand_in(real_futures, _NAMES),)
"""The modules that the code under test sees."""


def _renew(pool: Any) -> ThreadPoolExecutor:
    """A pool like one that a module has made when it was imported."""
    names = vars(pool)
    name = pool._thread_name_prefix
    made = ThreadPoolExecutor(pool._max_workers, "" if name.startswith("ThreadPoolExecutor-") else name)
    if "_initializer" in names:
        made._initialize = lambda: pool._initializer and pool._initializer(*pool._initargs)
    else:  # from Python 3.14 on
        made._initialize = lambda: pool._create_worker_context().initialize()
    made._is_shut_down = pool._shutdown
    return made


RENEWED: dict[type, Callable[[Any], object]] = {real_futures.ThreadPoolExecutor: _renew}
"""Class of an object that a module has -> makes a new one like it."""
