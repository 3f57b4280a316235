"""`rclpy.experimental.EventsExecutor`: callbacks in the order in which what they are for has come, groups ignored.

In `rclpy` it is a part of the extension, and no subclass of its executors. Here it is one: what an executor does with
nodes, tasks and futures is the same.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator
from typing import Any

from pytest_hricdv.extra.ros2.clocks import whole_ns
from pytest_hricdv.extra.ros2.executor import Entities, Ready
from pytest_hricdv.extra.ros2.handles import running_kernel

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

_TASKS_EVERY_NS = 1_000_000
"""How often tasks that wait are looked at, where nothing else happens. `rclpy` does so all the time, a whole core long;
chosen: a thousandth of a second is less than what nodes of Python wait for."""


def events_executor(executors: Any) -> type[Any]:
    """The class.

    Args:
        executors: the module `rclpy.executors`.
    """

    class EventsExecutor(executors.SingleThreadedExecutor):  # type: ignore[misc]
        def __init__(self, context: Any) -> None:
            super().__init__(context=context)
            self._tasks: list[tuple[Any, Any, Any]]
            self._spins = False

        def spin(self) -> None:
            self._run(lambda: False, None)

        def spin_once(self, timeout_sec: float | None = None) -> None:
            self._run(lambda: False, timeout_sec, at_most_one=True)

        def spin_until_future_complete(self, future: Any, timeout_sec: float | None = None) -> None:
            future.add_done_callback(lambda _: self.wake())
            self._run(future.done, timeout_sec)

        def spin_once_until_future_complete(self, future: Any, timeout_sec: float | None = None) -> None:
            future.add_done_callback(lambda _: self.wake())
            self._run(future.done, timeout_sec, at_most_one=True)

        def can_execute(self, entity: Any) -> bool:
            return not entity._executor_event

        def _run(self, is_over: Callable[[], bool], timeout_sec: float | None, *, at_most_one: bool = False) -> None:
            if self._spins:
                raise RuntimeError("Attempt to spin an already-spinning Executor")
            self._spins = True
            kernel = running_kernel("spin")
            lasts = timeout_sec is not None and timeout_sec >= 0
            end_ns = kernel.now_us * 1000 + whole_ns(float(timeout_sec or 0.0)) if lasts else None
            try:
                while self._context.ok() and not self._is_shutdown and not is_over():
                    has_run = self._run_next(end_ns)
                    if (has_run and at_most_one) or (not has_run and _is_past(end_ns)):
                        return
            finally:
                self._spins = False

        def _run_next(self, end_ns: int | None) -> bool:
            """Run the tasks that go on, or the next callback, or wait for one; whether anything was run."""
            begun = self._tasks_begun()
            if any(self._step(task, entity, node) for task, entity, node in begun):
                return True
            nodes = self.get_nodes()
            if any(True for node in nodes for _ in node.guards):
                raise RuntimeError("Guard conditions not supported")
            entities = Entities(self, nodes)
            looks_ns = running_kernel("spin").now_us * 1000 + _TASKS_EVERY_NS if begun else None
            until_ns = min((ns for ns in (end_ns, looks_ns) if ns is not None), default=None)
            ready, _ = entities.wait(until_ns)
            if not ready or self._is_shutdown or not self._context.ok():
                return False
            entity, node, take = min(ready, key=_came)
            self._step(self._make_handler(entity, node, take), entity, node)
            return True

        def _tasks_begun(self) -> list[tuple[Any, Any, Any]]:
            with self._tasks_lock:
                self._tasks = [own for own in self._tasks if not (own[0].done() or own[0].cancelled())]
                return list(self._tasks)

        def _step(self, task: Any, entity: Any, node: Any) -> bool:
            """Go on with a task; whether it is over. Raises what it raised, once it has been logged."""
            task()
            if not task.done():
                return False
            error = task.exception()
            if error is not None:
                _log(self, error, node, entity)
                raise error
            return True

        def _make_handler(self, entity: Any, node: Any, take: Callable[[Any], Any]) -> Any:
            entity._executor_event = True

            async def handle() -> None:
                execute = take(entity)
                entity._executor_event = False
                if execute is not None:
                    await execute()

            task = executors.Task(handle, executor=self)
            with self._tasks_lock:
                self._tasks.append((task, entity, node))
            return task

    return EventsExecutor


def _is_past(end_ns: int | None) -> bool:
    return end_ns is not None and end_ns <= running_kernel("spin").now_us * 1000


def _came(ready: Ready) -> tuple[int, int]:
    """When what an entity is for has come: (ns of simulated time, number of what has come)."""
    entity = ready[0]
    handle = getattr(entity, "handle", None)
    came = None if handle is None else handle.came()
    return came if came is not None else (running_kernel("spin").now_us * 1000, 0)


_KINDS = ("timers", "subscriptions", "clients", "services", "waitables")


def _log(executor: Any, error: BaseException, node: Any, entity: Any) -> None:
    """As the extension does: by the logger of the node whose callback it was."""
    from rclpy.logging import get_logger  # type: ignore[import-not-found, unused-ignore]

    nodes = [node] if node is not None else executor.get_nodes()
    logger = nodes[0].get_logger() if len(nodes) == 1 else get_logger("UNKNOWN")
    kinds: Iterator[str] = (kind for kind in _KINDS if node is not None and entity in getattr(node, kind))
    logger.fatal(f"Exception in '{next(kinds, 'task')}' callback: {error}")
    logger.warning("Error occurred at:\n" + "".join(traceback.format_tb(error.__traceback__)))
