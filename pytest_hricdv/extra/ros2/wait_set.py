"""Simulates guard conditions and wait sets of `rclpy`: a wait set blocks its node until a handle in it is ready.

`extension` gives `GuardCondition` and `WaitSet` to `rclpy`; the simulated world waits with a `WaitSet`, too. `executor`
calls `block_until_woken`, which blocks a node in the kernel.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partialmethod

from pytest_hricdv.extra.ros2.clocks import RosTimer
from pytest_hricdv.extra.ros2.contexts import Context
from pytest_hricdv.extra.ros2.handles import Destroyable, Waitable, current_kernel
from pytest_hricdv.runtime.kernel import US_PER_S, Kernel

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

# The kinds of handles that a wait set has
_KINDS = ("subscription", "guard_condition", "timer", "client", "service", "event")


class GuardCondition(Waitable):
    """Like `rcl_guard_condition_t`: triggered until a wait set takes it. Raises RCLError if its context has ended."""

    def __init__(self, context: Context) -> None:
        super().__init__(context.kernel)
        context.require_valid("create guard condition")
        self._triggered = False

    def trigger_guard_condition(self) -> None:
        """Wake the wait sets that wait for this, or the next one that does."""
        self._triggered = True
        self.wake()

    def is_ready(self) -> bool:
        """Whether it was triggered."""
        return self._triggered

    def take_readiness(self) -> bool:
        """Whether it was triggered; resets it."""
        triggered, self._triggered = self._triggered, False
        return triggered


class WaitSet(Destroyable):
    """Like `rcl_wait_set_t`. The numbers of handles of each kind, which the extension wants, are not needed."""

    def __init__(self, *numbers_and_context: object) -> None:
        super().__init__(current_kernel("a wait set of rclpy"))
        self.clear_entities()

    def clear_entities(self) -> None:
        """Wait for nothing."""
        self._entities: dict[str, list[Waitable]] = {kind: [] for kind in _KINDS}
        self._ready: dict[str, list[bool]] = {kind: [] for kind in _KINDS}

    def _add(self, kind: str, entity: Waitable) -> int:
        """Add a handle to wait for. Returns its index."""
        self._entities[kind].append(entity)
        return len(self._entities[kind]) - 1

    add_subscription = partialmethod(_add, "subscription")
    add_guard_condition = partialmethod(_add, "guard_condition")
    add_timer = partialmethod(_add, "timer")
    add_client = partialmethod(_add, "client")
    add_service = partialmethod(_add, "service")
    add_event = partialmethod(_add, "event")

    def is_ready(self, entity_type: str, index: int) -> bool:
        """Whether the handle of that kind and index was ready when the wait ended.

        Raises:
            RuntimeError: there is no such kind.
            IndexError: there is no such index.
        """
        self._require_kind(entity_type)
        if index >= len(self._entities[entity_type]):
            raise IndexError("wait set index too big")
        ready = self._ready[entity_type]
        return index < len(ready) and ready[index]

    def get_ready_entities(self, entity_type: str) -> list[int]:
        """The pointers of the handles of that kind that were ready when the wait ended."""
        self._require_kind(entity_type)
        flags = zip(self._entities[entity_type], self._ready[entity_type], strict=False)
        return [entity.pointer for entity, ready in flags if ready]

    @property
    def entities(self) -> list[Waitable]:
        return [entity for kind in _KINDS for entity in self._entities[kind]]

    def any_is_ready(self) -> bool:
        """Whether any of it is ready."""
        return any(entity.is_ready() for entities in self._entities.values() for entity in entities)

    def wait(self, timeout: int) -> None:
        """Block until a handle is ready, at most `timeout` (ns; negative: as long as it takes; 0: not at all)."""
        entities = self.entities
        kernel = self.kernel
        end_ns = None if timeout < 0 else kernel.now_us * 1000 + timeout
        if timeout == 0:
            kernel.count_poll()
        while not self.any_is_ready():
            due_ns = [due for entity in entities if (due := entity.due_ns()) is not None]
            until_ns = min(due_ns if end_ns is None else [*due_ns, end_ns], default=None)
            if end_ns is not None and end_ns <= kernel.now_us * 1000:
                break
            block_until_woken(kernel, entities, until_ns)
        self.take()

    def take(self) -> None:
        """Note what is ready now; triggered guard conditions are not any more."""
        self._ready = {kind: [entity.take_readiness() for entity in self._entities[kind]] for kind in _KINDS}

    def _require_kind(self, kind: str) -> None:
        if kind not in _KINDS:
            raise RuntimeError(f"'{kind}' is not a known entity")


def block_until_woken(kernel: Kernel, entities: Sequence[Waitable], until_ns: int | None) -> None:
    """Block until a handle is woken, or the kernel's time is `until_ns`, rounded up to its resolution."""
    node = kernel.current()
    queues = [entity.waiting for entity in entities]
    queues += [entity.clock.waiting for entity in entities if isinstance(entity, RosTimer)]
    for queue in queues:
        queue.append(node)
    try:
        # Rounded up, so that what is due then is due when the node continues.
        wait_us = None if until_ns is None else max(-(-until_ns // 1000) - kernel.now_us, 0)
        kernel.block(None if wait_us is None else wait_us / US_PER_S)
    finally:
        for queue in queues:
            queue.remove(node)
