"""The locks of `threading` for nodes: they block in the kernel, and wake waiting nodes in order of arrival.

They also serve the world and other code outside of a node, which can release and set, but not wait.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Any, NoReturn

from greenlet import getcurrent, greenlet

from pytest_hricdv.runtime.blocking_calls import THREADING
from pytest_hricdv.runtime.kernel import Node, current_node
from pytest_hricdv.runtime.virtual.clocks import monotonic, seconds
from pytest_hricdv.runtime.virtual.real_time import node_to_wait

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all


class WaitQueue:
    """The nodes that wait for one thing, in the order in which they came.

    Args:
        kind: the kind of the wait, see `real_time.KINDS`.
        name: what they wait in, as the code under test calls it.
    """

    def __init__(self, kind: str, name: str) -> None:
        self._kind = kind
        self._name = name
        self.nodes: deque[Node] = deque()
        """To be read only."""
        self.unheard_s: float | None = None
        """When the last lost wake-up came (s of simulated time)."""

    def __len__(self) -> int:
        return len(self.nodes)

    def __reduce__(self) -> NoReturn:
        raise TypeError("cannot pickle '_thread.lock' object")  # as for Python's, in whatever object it is

    def wait(self, timeout_s: float | None = None) -> bool:
        """Block the running node until it is woken, at most `timeout_s`; whether it was woken."""
        node = node_to_wait(self._kind, self._name)
        self.nodes.append(node)
        try:
            return node.kernel.block(None if timeout_s is None else seconds(timeout_s))
        finally:
            if node in self.nodes:  # on a time-out, or at the end of the run
                self.nodes.remove(node)

    def wake(self, count: int = 1) -> list[Node]:
        """Wake the first `count` of them, or others if the run's schedule says so; returns these."""
        woken: list[Node] = []
        while self.nodes and len(woken) < count:
            is_choice = len(self.nodes) > count - len(woken)
            number = self.nodes[0].kernel.choose(len(self.nodes)) if is_choice else 0
            woken.append(self.nodes[number])
            del self.nodes[number]
            woken[-1].kernel.wake(woken[-1])
        return woken


def _count_poll() -> None:
    node = current_node()
    if node is not None:
        node.kernel.count_poll()


def _check_timeout(blocking: bool, timeout_s: float) -> None:
    """Refuse what Python's locks refuse."""
    if not blocking:
        raise ValueError("can't specify a timeout for a non-blocking call")
    if timeout_s < 0:
        raise ValueError("timeout value must be a non-negative number")


class Lock:
    """Like `threading.Lock`. A released lock belongs to the waiter that is woken."""

    def __init__(self) -> None:
        self._locked = False
        self._waiting = WaitQueue(THREADING, "Lock.acquire")
        self.holder: Node | None = None
        """The node that took it last; it need not be the one that releases it."""

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        """Take it, if need be after waiting for `timeout` (s; -1: as long as it takes); whether it was taken."""
        if timeout != -1:
            _check_timeout(blocking, seconds(timeout))
        if not self._locked:
            self._locked = True
            self.holder = current_node()
            return True
        if not blocking:
            _count_poll()
            return False
        return self._waiting.wait(None if timeout < 0 else timeout)

    def release(self) -> None:
        """Hand it to a waiter. Raises RuntimeError if it is not held."""
        if not self._locked:
            raise RuntimeError("release unlocked lock")
        # It stays locked where somebody waits: another node that runs before the woken one must not take it.
        woken = self._waiting.wake()
        self.holder, self._locked = (woken[0], True) if woken else (None, False)

    def locked(self) -> bool:
        """Whether somebody has it."""
        return self._locked

    is_mine = locked  # it does not know whose it is

    def give_up(self) -> int:
        """Release it; returns how often it had been taken: once."""
        self.release()
        return 1

    def take_back(self, depth: int) -> None:
        """Take it again, whatever `depth`."""
        self.acquire()

    def __enter__(self) -> bool:
        return self.acquire()

    def __exit__(self, *_: object) -> None:
        self.release()

    def __reduce__(self) -> NoReturn:
        raise TypeError("cannot pickle '_thread.lock' object")

    def __repr__(self) -> str:
        return f"<{'locked' if self._locked else 'unlocked'} _thread.lock object at {id(self):#x}>"


class RLock:
    """Like `threading.RLock`."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._owner: greenlet | None = None
        self._depth = 0

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        """Like `Lock.acquire`; its owner takes it once more."""
        if timeout != -1:
            _check_timeout(blocking, seconds(timeout))
        if self._owner is not getcurrent():
            if not self._lock.acquire(blocking, timeout):
                return False
            self._owner = getcurrent()
        self._depth += 1
        return True

    def release(self) -> None:
        """Undo one `acquire`. Raises RuntimeError in who does not have it."""
        if self._owner is not getcurrent():
            raise RuntimeError("cannot release un-acquired lock")
        self._depth -= 1
        if not self._depth:
            self.give_up()

    def give_up(self) -> int:
        """Release it altogether; returns how often it had been taken."""
        depth, self._depth, self._owner = self._depth, 0, None
        self._lock.release()
        return depth

    def take_back(self, depth: int) -> None:
        """Take it as often as it had been."""
        self._lock.acquire()
        self._owner, self._depth = getcurrent(), depth

    def is_mine(self) -> bool:
        """Whether the caller has it."""
        return self._owner is getcurrent()

    def __enter__(self) -> bool:
        return self.acquire()

    def __exit__(self, *_: object) -> None:
        self.release()

    def __reduce__(self) -> NoReturn:
        raise TypeError("cannot pickle '_thread.RLock' object")

    def __repr__(self) -> str:
        state = "locked" if self._depth else "unlocked"
        return f"<{state} _thread.RLock object count={self._depth} at {id(self):#x}>"


class Condition:
    """Like `threading.Condition`."""

    def __init__(self, lock: Lock | RLock | None = None) -> None:
        self._lock = RLock() if lock is None else lock
        self._waiting = WaitQueue(THREADING, "Condition.wait")
        self.acquire, self.release = self._lock.acquire, self._lock.release

    def __enter__(self) -> bool:
        return self._lock.__enter__()

    def __exit__(self, *_: object) -> None:
        self._lock.__exit__()

    def wait(self, timeout: float | None = None) -> bool:
        """Release the lock, wait for `notify`, at most `timeout` (s), take the lock again; whether it was notified."""
        self._check("wait on")
        depth = self._lock.give_up()
        try:
            return self._waiting.wait(None if timeout is None else max(timeout, 0.0))
        finally:
            self._lock.take_back(depth)

    def wait_for(self, predicate: Callable[[], object], timeout: float | None = None) -> object:
        """Wait until `predicate()` is true, at most `timeout` (s); returns its last value."""
        end_s = None if timeout is None else monotonic() + timeout
        while not (result := predicate()):
            left_s = None if end_s is None else end_s - monotonic()
            if left_s is not None and left_s <= 0:
                break
            self.wait(left_s)
        return result

    def notify(self, n: int = 1) -> None:
        """Wake the first `n` that wait."""
        self._check("notify on")
        if not self._waiting.wake(n):
            self._waiting.unheard_s = monotonic()

    def notify_all(self) -> None:
        """Wake all that wait."""
        self.notify(len(self._waiting))

    def _check(self, use: str) -> None:
        if not self._lock.is_mine():
            raise RuntimeError(f"cannot {use} un-acquired lock")


class Event:
    """Like `threading.Event`."""

    def __init__(self) -> None:
        self._is_set = False
        self._set_unheard_s: float | None = None
        self._waiting = WaitQueue(THREADING, "Event.wait")

    def is_set(self) -> bool:
        """Whether it is set."""
        _count_poll()  # `while not event.is_set()` is a loop that never sleeps
        self._set_unheard_s = None
        return self._is_set

    def set(self) -> None:
        """Set it, and wake all that wait for it."""
        self._is_set = True
        self._set_unheard_s = None if self._waiting.wake(len(self._waiting)) else monotonic()

    def clear(self) -> None:
        """Unset it."""
        self._is_set = False
        self._waiting.unheard_s = self._set_unheard_s

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until it is set, at most `timeout` (s); whether it was set."""
        if self._is_set:
            self._set_unheard_s = None
        return self._is_set or self._waiting.wait(None if timeout is None else max(timeout, 0.0))

    def __repr__(self) -> str:
        return f"<threading.Event at {id(self):#x}: {'set' if self._is_set else 'unset'}>"


class Semaphore:
    """Like `threading.Semaphore`."""

    def __init__(self, value: int = 1) -> None:
        if value < 0:
            raise ValueError("semaphore initial value must be >= 0")
        self._value = value
        self._waiting = WaitQueue(THREADING, "Semaphore.acquire")

    def acquire(self, blocking: bool = True, timeout: float | None = None) -> bool:
        """Take one, if need be after waiting for `timeout` (s); whether one was taken."""
        if not blocking and timeout is not None:
            raise ValueError("can't specify timeout for non-blocking acquire")
        if self._value:
            self._value -= 1
            return True
        if not blocking:
            _count_poll()
            return False
        return self._waiting.wait(None if timeout is None else max(timeout, 0.0))

    def release(self, n: int = 1) -> None:
        """Give back `n`, each to the first that waits."""
        if n < 1:
            raise ValueError("n must be one or more")
        self._value += n - len(self._waiting.wake(n))

    def __enter__(self) -> bool:
        return self.acquire()

    def __exit__(self, *_: object) -> None:
        self.release()


class BoundedSemaphore(Semaphore):
    """Like `threading.BoundedSemaphore`."""

    def __init__(self, value: int = 1) -> None:
        super().__init__(value)
        self._first_value = value

    def release(self, n: int = 1) -> None:
        """Like that of `Semaphore`; raises ValueError for more than were taken."""
        if self._value + n > self._first_value:
            raise ValueError("Semaphore released too many times")
        super().release(n)


class Barrier(threading.Barrier):
    """Like `threading.Barrier`, which waits in its condition only."""

    def __init__(self, parties: int, action: Callable[[], None] | None = None, timeout: float | None = None) -> None:
        super().__init__(parties, action, timeout)
        self._cond = Condition(Lock())


RENEWED: dict[type, Callable[[Any], object]] = {
    type(threading.Lock()): lambda lock: Lock(),
    type(threading.RLock()): lambda lock: RLock(),
    threading.Condition: lambda condition: Condition(),
    threading.Event: lambda event: Event(),
    threading.Semaphore: lambda semaphore: Semaphore(semaphore._value),
    threading.BoundedSemaphore: lambda semaphore: BoundedSemaphore(semaphore._initial_value),
}
"""Class of an object that a module has -> makes a new one like it."""
