"""What the testbench's `run` is called with: one run of one concrete test."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field

from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest
from pytest_hricdv.monitor import MonitorSet
from pytest_hricdv.runtime import Bus, Kernel, Recorder

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too


@dataclass
class Run:
    """What the testbench's `run` works with: virtual time, bus, record, and the test to enact."""

    test: ConcreteTest
    kernel: Kernel
    bus: Bus
    recorder: Recorder
    measured: Callable[[Callable[[], None]], Callable[[], None]]
    """Wraps the body of the node that is the code under test: coverage is measured in this node's greenlet only."""
    monitors: MonitorSet = field(repr=False)
    filming: Callable[[Run], AbstractContextManager[None]] | None = None
    """Entered around the run when it is filmed; None otherwise."""
    acted_s: list[float] = field(default_factory=list)
    """When each action began (s of simulated time), as far as `actions` or `acting` reported it."""

    def actions(self) -> Iterator[ConcreteAction]:
        """The test's actions, one after the other; taking the next one reports that it begins now."""
        for number, action in enumerate(self.test.actions):
            self.acting(number)
            yield action

    def acting(self, number: int) -> None:
        """Report that action `number` (from 0, in order) begins now; explanations of failures show these times."""
        if number == len(self.acted_s) < len(self.test.actions):
            self.acted_s.append(self.kernel.now_s)

    def go(self, limit_s: float) -> str:
        """Run the nodes up to `limit_s`, then on until no monitor has an open deadline; then end all nodes.

        Returns:
            Why it ended: what was given to `kernel.stop`, "idle", or "limit".
        """
        with nullcontext() if self.filming is None else self.filming(self):
            try:
                ended = self.kernel.run(limit_s)
                while (deadline_s := self._open_deadline_s()) is not None:
                    if self.kernel.run(deadline_s) == "idle":
                        self.kernel.skip(deadline_s)
            finally:
                self.kernel.close()
        return ended

    def _open_deadline_s(self) -> float | None:
        deadline_s = self.monitors.next_deadline_s()
        return deadline_s if deadline_s is not None and self.kernel.now_s < deadline_s else None
