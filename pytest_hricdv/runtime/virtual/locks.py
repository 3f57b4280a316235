"""The locks of `threading` for nodes: they block in the kernel, and wake waiting nodes in order of arrival.

They also serve the world and other code outside of a node, which can release and set, but not wait.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence

from greenlet import getcurrent, greenlet

from pytest_hricdv.runtime.blocking_calls import THREADING
from pytest_hricdv.runtime.kernel import Node, current_node
from pytest_hricdv.runtime.source_location import place_of
from pytest_hricdv.runtime.virtual.clocks import monotonic
from pytest_hricdv.runtime.virtual.real_time import node_to_wait

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all


class WaitQueue:
    """The nodes that wait for one thing, in the order in which they came.

    Args:
        kind: of the wait, see `real_time.KINDS`.
        name: what they wait in, as the code under test calls it.
    """

    def __init__(self, kind: str, name: str) -> None:
        self._kind = kind
        self._name = name
        self.nodes: deque[Node] = deque()
        """To be read only."""

    def __len__(self) -> int:
        return len(self.nodes)

    def wait(self, timeout_s: float | None = None) -> bool:
        """Block the running node until it is woken, at most `timeout_s`; whether it was woken."""
        node = node_to_wait(self._kind, self._name)
        self.nodes.append(node)
        try:
            return node.kernel.block(timeout_s)
        finally:
            if node in self.nodes:  # on a time-out, or at the end of the run
                self.nodes.remove(node)

    def wake(self, count: int = 1) -> int:
        """Wake the first `count` of them; returns how many there were."""
        woken = min(count, len(self.nodes))
        for _ in range(woken):
            node = self.nodes.popleft()
            node.kernel.wake(node)
        return woken


def _lock_waited_for(node: Node) -> Lock | None:
    """The lock that a node waits for without a time-out; None where it does something else."""
    frame = node.frame if node.kernel.waits_for_ever(node) else None
    while frame is not None:
        if frame.f_code is Lock.acquire.__code__:
            found = frame.f_locals["self"]
            return found if isinstance(found, Lock) else None
        frame = frame.f_back
    return None


def find_deadlocks(nodes: Sequence[Node]) -> Iterator[str]:
    """Deadlocks: a sentence for each cycle of nodes that wait for locks of each other.

    A node that waits for a lock that it holds itself is none: another node may release it, as a signal.
    """
    waits = {node: lock for node in nodes if (lock := _lock_waited_for(node)) is not None}
    named: set[Node] = set()
    for node in waits:
        cycle: list[Node] = []
        here: Node | None = node
        while here in waits and here not in cycle and here not in named:
            cycle.append(here)
            here = waits[here].holder
        if here in cycle:
            cycle = cycle[cycle.index(here) :]
            named.update(cycle)
        if here in cycle and len(cycle) > 1:
            yield f"deadlock: {'; '.join(_wait_text(one, waits[one].holder) for one in cycle)}"


def _wait_text(node: Node, holder: Node | None) -> str:
    assert holder is not None
    return f"{node.name} waits at {place_of(node.frame)} for a lock that {holder.name} holds"


def _count_poll() -> None:
    node = current_node()
    if node is not None:
        node.kernel.count_poll()


class Lock:
    """As `threading.Lock`. A lock that is released belongs to the first that waits for it."""

    def __init__(self) -> None:
        self._locked = False
        self._waiting = WaitQueue(THREADING, "Lock.acquire")
        self.holder: Node | None = None
        """The node that took it last; it need not be the one that releases it."""

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        """Take it, if need be after waiting for `timeout` (s; -1: as long as it takes); whether it was taken."""
        if not self._locked:
            self._locked = True
            self.holder = current_node()
            return True
        if not blocking:
            _count_poll()
            return False
        return self._waiting.wait(None if timeout < 0 else timeout)

    def release(self) -> None:
        """Hand it to the first that waits. Raises RuntimeError if nobody has it."""
        if not self._locked:
            raise RuntimeError("release unlocked lock")
        # It stays locked where somebody waits: another node that runs before the woken one must not take it.
        self.holder = self._waiting.nodes[0] if self._waiting.nodes else None
        self._locked = bool(self._waiting.nodes) and bool(self._waiting.wake())

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


class RLock:
    """As `threading.RLock`."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._owner: greenlet | None = None
        self._depth = 0

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        """As `Lock.acquire`; who has it takes it once more."""
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


class Condition:
    """As `threading.Condition`."""

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
        self._waiting.wake(n)

    def notify_all(self) -> None:
        """Wake all that wait."""
        self.notify(len(self._waiting))

    def _check(self, use: str) -> None:
        if not self._lock.is_mine():
            raise RuntimeError(f"cannot {use} un-acquired lock")


class Event:
    """As `threading.Event`."""

    def __init__(self) -> None:
        self._is_set = False
        self._waiting = WaitQueue(THREADING, "Event.wait")

    def is_set(self) -> bool:
        """Whether it is set."""
        _count_poll()  # `while not event.is_set()` is a loop that never sleeps
        return self._is_set

    def set(self) -> None:
        """Set it, and wake all that wait for it."""
        self._is_set = True
        self._waiting.wake(len(self._waiting))

    def clear(self) -> None:
        """Unset it."""
        self._is_set = False

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until it is set, at most `timeout` (s); whether it was set."""
        return self._is_set or self._waiting.wait(None if timeout is None else max(timeout, 0.0))


class Semaphore:
    """As `threading.Semaphore`."""

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
        self._value += n - self._waiting.wake(n)

    def __enter__(self) -> bool:
        return self.acquire()

    def __exit__(self, *_: object) -> None:
        self.release()


class BoundedSemaphore(Semaphore):
    """As `threading.BoundedSemaphore`."""

    def __init__(self, value: int = 1) -> None:
        super().__init__(value)
        self._first_value = value

    def release(self, n: int = 1) -> None:
        """As of `Semaphore`; raises ValueError for more than were taken."""
        if self._value + n > self._first_value:
            raise ValueError("Semaphore released too many times")
        super().release(n)


class Barrier(threading.Barrier):
    """As `threading.Barrier`, which waits in its condition only."""

    def __init__(self, parties: int, action: Callable[[], None] | None = None, timeout: float | None = None) -> None:
        super().__init__(parties, action, timeout)
        self._cond = Condition(Lock())
