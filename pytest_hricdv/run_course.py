"""`RunCourse`: runs the nodes of a run to its time limit, then on to the deadlines of monitors that are open.

`Run.go` calls `RunCourse.run`, which returns the kernel's reason for the end, and an `Ending`: how and when it ended.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from pytest_hricdv.monitor import MonitorSet
from pytest_hricdv.runtime import Kernel, NodeError, Recorder
from pytest_hricdv.runtime.kernel import US_PER_S
from pytest_hricdv.runtime.livelock import LOOKS_EACH_S, Cycle, RepetitionDetector

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too


@dataclass(frozen=True)
class Ending:
    """How a run ended, and when (s of simulated time): "stopped", "limit", "idle", "cycle", "failed" (with the error).

    `cycle` is set if the run repeated the same messages up to its end.
    """

    how: str
    time_s: float
    error: NodeError | None = None
    cycle: Cycle | None = None


INSTANT_S = 1e-6
"""The kernel's resolution of time."""


@dataclass(frozen=True)
class RunCourse:
    """Runs the nodes of one run.

    Args:
        actions: the number of actions that have begun.
        senders: the senders of messages -> whether it is the code under test.
        may_go_round: whether the run may repeat itself without limit; otherwise it is ended (see `runtime.livelock`).
    """

    kernel: Kernel
    monitors: MonitorSet
    recorder: Recorder
    actions: Callable[[], int]
    senders: Mapping[str, bool]
    may_go_round: bool

    def run(self, limit_s: float) -> tuple[str, Ending]:
        """Run up to the limit (s), or until nothing new comes.

        Returns:
            Why it ended, as the kernel says, and how.
        """
        cycle: Cycle | None = None
        repetition = RepetitionDetector(
            self.kernel, self.recorder, self.actions, lambda sender: self.senders.get(sender, False)
        )

        def look() -> None:
            nonlocal cycle
            cycle = cycle or repetition.cycle()
            if cycle is not None:
                self.kernel.stop("goes round")

        if not self.may_go_round:
            self.kernel.look_each(LOOKS_EACH_S, look)
        why = self.kernel.run(limit_s)
        self.kernel.look_each(math.inf, lambda: None)
        how = "cycle" if cycle is not None and why == "goes round" else "stopped" if self.kernel.is_stopped else why
        if how == "limit" and not self.may_go_round:
            cycle = repetition.cycle(self.kernel.now_s / 2)
        return why, Ending(how, self.kernel.now_s, cycle=cycle)

    def finish(self, why: str) -> None:
        """Run on to the last deadline that is open now; `why` it ended, as the kernel says."""
        if why == "idle" and self.monitors.is_instant_open:  # what begins at the last instant is not pending
            self.kernel.skip(self.kernel.now_s + INSTANT_S)
        # An instant is judged once it is over, and what happened at the last one may have met a deadline.
        self._run_to_deadlines(self.kernel.now_us + 1)
        # Later triggers do not count: a topic at 10 Hz that nobody answers would continue for ever.
        self._run_to_deadlines()

    def _run_to_deadlines(self, until_us: int | None = None) -> None:
        """Run up to the last deadline that is open now, at most to `until_us`.

        In whole microseconds, as the clock counts: a time in seconds may be a little later than the one it stands for,
        and an idle run would never reach it.
        """
        self.monitors.advance(self.kernel.now_s)
        deadline_us = self._open_deadline_us()
        if deadline_us is None:
            return
        end_us = deadline_us if until_us is None else min(deadline_us, until_us)
        end_s = end_us / US_PER_S
        while self.kernel.now_us < end_us:  # a node may stop the run once more
            if self.kernel.run(end_s) == "idle":
                self.kernel.skip(end_s)
        self.monitors.advance(self.kernel.now_s)

    def _open_deadline_us(self) -> int | None:
        """The first microsecond at which the last open deadline has come; None if that is not later than now."""
        deadline_s = self.monitors.next_deadline_s()
        if deadline_s is None:
            return None
        deadline_us = -(-round(deadline_s * 1e9) // 1000)  # deadlines have whole nanoseconds
        return deadline_us if self.kernel.now_us < deadline_us else None
