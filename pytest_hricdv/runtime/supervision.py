"""`Supervision`: limits the processor time and real time of a run for its `Kernel`; beyond them, the run fails."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn, Protocol

from pytest_hricdv.runtime.blocking_calls import real_wait
from pytest_hricdv.runtime.node_error import KernelError, NodeError
from pytest_hricdv.runtime.source_location import place_of
from pytest_hricdv.runtime.watchdog import Hang, Watch, WatchState

US_PER_S = 1_000_000

STUCK_AFTER_S = 8.0
"""A node hangs if it uses this much processor time (s) while no simulated time passes: four times what motion planning
takes. The watchdog looks at intervals, so the node is ended within 10 s."""

CRAWLS = 7.5
"""Limit of processor time for a second of simulated time, in multiples of `STUCK_AFTER_S`: a minute. Physics that is
rendered thirty times per simulated second takes ten seconds of it."""

NODE_WAITS_S = 0.5
"""How long nodes may wait in real time (s; chosen). Virtual time needs no such waits: this is for locks of libraries
that compute in threads of their own."""

WORLD_WAITS_S = 60.0
"""How long the world, and the testbench's `run` outside of nodes, may wait without time passing (s of real time;
chosen): for a simulator in another process."""

_STUCK, _SLOW = "no time has passed for", "a second of simulated time takes more than"
_WAITS = "the world waits in real time", "run waits in real time"
"""Parts of errors of code that worked or waited for too long."""

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all


def took_long(errors: Iterable[str]) -> bool:
    """Whether one of a run's errors is that something worked or waited for too long: it takes ten seconds or more."""
    return any(part in error for error in errors for part in (_STUCK, _SLOW, *_WAITS))


class SupervisedNode(Protocol):
    """A node, as far as supervision needs it."""

    name: str


class SupervisedKernel(Protocol):
    """The kernel, as far as supervision needs it."""

    now_us: int
    virtual: frozenset[str]
    code: tuple[str, ...]
    returns: int
    refusals: list[KernelError]

    @property
    def inside(self) -> SupervisedNode | None: ...

    @property
    def now_s(self) -> float: ...

    @property
    def is_running(self) -> bool: ...

    def node_info(self) -> str: ...

    def abandon(self, error: BaseException) -> NoReturn: ...


class Supervision:
    """Interrupts code that keeps a run from advancing.

    Args:
        stuck_after_s: how long code may work without time passing (s of processor time); infinity: no limit.
    """

    def __init__(self, kernel: SupervisedKernel, stuck_after_s: float) -> None:
        self._kernel = kernel
        self._stuck_after_s = stuck_after_s
        self._node_waits_s = min(NODE_WAITS_S, stuck_after_s)
        self._watch = Watch(self.situation, self._interrupt)
        self._is_watched = False
        self._world_waits = False  # it has waited for too long once: nothing comes
        self._interrupted: int | None = None  # `Kernel.returns` when something was raised in what had control

    @contextmanager
    def watch(self) -> Iterator[None]:
        """Context manager that interrupts code that never yields, or waits in real time. `Kernel.run` enters it itself.

        The watchdog has no effect outside of the main thread, and on systems without signals.
        """
        if self._is_watched or self._stuck_after_s == math.inf:
            yield
            return
        self._is_watched = True
        try:
            with self._watch.watch():
                yield
        finally:
            self._is_watched = False

    def situation(self) -> WatchState:
        """The present activity, for the watchdog."""
        if self._kernel.inside is not None:
            waits_s, adds_up = self._node_waits_s, True
        else:
            longest_s = max(WORLD_WAITS_S, 2 * self._stuck_after_s)
            waits_s, adds_up = NODE_WAITS_S if self._world_waits else longest_s, False
        if self._kernel.inside is not None or self._kernel.is_running:
            second = self._kernel.now_us // US_PER_S
            return WatchState(
                self._kernel.now_us,
                waits_s,
                self._stuck_after_s,
                adds_up,
                second,
                may_take_s=CRAWLS * self._stuck_after_s,
            )
        return WatchState(self._kernel.now_us, WORLD_WAITS_S)

    def _interrupt(self, problem: Hang, frame: FrameType | None) -> None:
        """Interrupt the running code. A node that has caught the exception is abandoned."""
        error = self._error_of(problem, frame)
        node = self._kernel.inside
        if node is not None and self._interrupted == self._kernel.returns:
            self._kernel.abandon(NodeError(node.name, self._kernel.now_s, f"catches whatever is raised in it: {error}"))
        self._interrupted = self._kernel.returns
        if node is not None:
            self._kernel.refusals.append(error)
        raise error

    def _error_of(self, problem: Hang, frame: FrameType | None) -> KernelError:
        place = f"{place_of(frame)}{self._kernel.node_info()}"
        if problem.kind == "works":
            return KernelError(f"{_STUCK} {self._stuck_after_s:g} s of work, at {place}")
        if problem.kind == "crawls":
            return KernelError(
                f"{_SLOW} {problem.taken_s:.0f} s of work, now at "
                f"{place}: sleep longer between two steps, or let a step take less; if the world is "
                "this slow, give the testbench time=VirtualTime(stall_timeout_s=...) with a larger one"
            )
        who = "the world" if self._kernel.is_running else "run"
        if self._kernel.inside is not None:
            who = f"node {self._kernel.inside.name}"
        else:
            self._world_waits = True
        return KernelError(real_wait(frame, who, self._kernel.code, self._kernel.virtual))
