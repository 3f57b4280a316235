"""Base classes of the handles that `rclpy` holds, such as publishers: `Destroyable`, and `Waitable` for wait sets.

Other modules of this package derive their classes from these. `current_kernel` returns the kernel of the node that
calls it; `RCLError` and `InvalidHandle` are the errors that `rclpy` expects.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from itertools import count
from typing import TYPE_CHECKING, Any

from pytest_hricdv.runtime.kernel import Kernel, Node, current_node
from pytest_hricdv.runtime.node_error import KernelError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all


class RCLError(RuntimeError):
    """Like the error of `rclpy`'s extension: the ROS client library refuses a call."""


class InvalidHandle(RuntimeError):  # noqa: N818 (the name is the extension's)
    """Like the error of `rclpy`'s extension: the handle was destroyed."""


def node_that_runs() -> Node | None:
    """The running node; None outside of nodes, and while Python ends and calls finalizers of `rclpy`."""
    try:
        return current_node()
    except RuntimeError:
        return None  # there are no greenlets any more


def current_kernel(action: str) -> Kernel:
    """The kernel of the running node.

    Raises:
        KernelError: outside of a node, where there is no virtual time.
    """
    node = current_node()
    if node is None:
        raise KernelError(f"{action}: only a node of a simulated run may do so")
    return node.kernel


def _numbers(kernel: Kernel) -> Iterator[int]:
    numbers = kernel.own.setdefault("ros2 handles", count(1))
    assert isinstance(numbers, count)
    return numbers


class Destroyable:
    """A handle. As a context manager it stays valid until the block ends, even if it is destroyed within the block.

    Once its run is over, all its methods have no effect: finalizers of `rclpy` destroy handles in an unknown order,
    also when Python collects the garbage of one run during the next one.

    Raises:
        InvalidHandle: entered after it was destroyed, in its run.
    """

    def __init__(self, kernel: Kernel | None) -> None:
        self._kernel = kernel
        self.pointer = 0 if kernel is None else next(_numbers(kernel))
        """Tells handles of one run apart, as the address of the extension's: the same in each repeat."""
        self._uses = 0
        self._has_let_go = False
        self.is_destroyed = False
        """Whether it is to be destroyed; it is, unless it is in use."""

    @property
    def kernel(self) -> Kernel:
        """The kernel of its run; of what was made while a module was imported, that of the node that uses it."""
        return self._kernel if self._kernel is not None else current_kernel("rclpy")

    def __enter__(self) -> None:
        if self.is_destroyed and self._is_in_its_run():
            raise InvalidHandle("cannot use Destroyable because destruction was requested")
        self._uses += 1

    def __exit__(self, *_: object) -> None:
        self._uses -= 1
        if self.is_destroyed:
            self._let_go()

    def destroy_when_not_in_use(self) -> None:
        """Destroy it now, or when the last block that uses it ends."""
        if self.is_destroyed:
            return
        self.is_destroyed = True
        self._let_go()

    def _let_go(self) -> None:
        """Destroy it, once, unless a block uses it."""
        if not self._uses and not self._has_let_go:
            self._has_let_go = True  # before: destroying may use the handle itself
            self.destroy()

    def _is_in_its_run(self) -> bool:
        node = node_that_runs()
        return node is not None and self._kernel in (node.kernel, None)

    def destroy(self) -> None:
        """Let go of what it holds; for subclasses."""


def arrival(kernel: Kernel) -> tuple[int, int]:
    """The simulated time (ns) of an arrival now, and its number in the run."""
    numbers = kernel.own.setdefault("ros2 arrivals", count(1))
    assert isinstance(numbers, count)
    return kernel.now_us * 1000, next(numbers)


class Waitable(Destroyable, ABC):
    """A handle that a wait set can wait for."""

    def __init__(self, kernel: Kernel) -> None:
        super().__init__(kernel)
        self.waiting: list[Node] = []
        """The nodes of the kernel that wait until it is ready."""
        self._on_new: Callable[[int], None] | None = None

    @abstractmethod
    def is_ready(self) -> bool:
        """Whether there is something to take."""

    def take_readiness(self) -> bool:
        """Whether it is ready, at the end of a wait; a guard condition is not any more afterwards."""
        return self.is_ready()

    def set_callback(self, callback: Callable[[int], None]) -> None:
        """Call it with the number of what comes from now on, and at once with that of what waits already."""
        self._on_new = callback
        if waiting := self._count_waiting():
            callback(waiting)

    def clear_callback(self) -> None:
        """Call nothing any more."""
        self._on_new = None

    def _count_waiting(self) -> int:
        return 0

    def _note_arrival(self) -> None:
        """Note one more arrival."""
        self.wake()
        if self._on_new is not None:
            self._on_new(1)

    def came(self) -> tuple[int, int] | None:
        """The time (ns) and number in the run of the arrival that made it ready; None if unknown."""
        return None

    def due_ns(self) -> int | None:
        """When it becomes ready by itself (ns of simulated time); None if it does not."""
        return None

    def wake(self) -> None:
        """Let those that wait for it look again."""
        for node in self.waiting:
            node.kernel.wake(node)


class QueueHandle(Waitable):
    """A handle with a queue: it is ready while there is something in it."""

    def __init__(self, kernel: Kernel) -> None:
        super().__init__(kernel)
        self._queue: deque[tuple[Any, Any, int, tuple[int, int]]] = deque()
        """Content, facts about it, a time (ns), and when it came."""

    def is_ready(self) -> bool:
        """Whether there is something in the queue."""
        return bool(self._queue)

    def came(self) -> tuple[int, int] | None:
        """The arrival of the oldest."""
        return self._queue[0][3] if self._queue else None

    def _count_waiting(self) -> int:
        return len(self._queue)

    def _enqueue(self, content: Any, facts: Any, time_ns: int) -> None:
        self._queue.append((content, facts, time_ns, arrival(self.kernel)))
        self._note_arrival()
