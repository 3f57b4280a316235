"""Schedules in the execution of tests: runs a test under its schedule, if it has one."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any

from pytest_hricdv.execution.execution_feature import ExecutionFeature

if TYPE_CHECKING:
    from pytest_hricdv.execution.faults import CodeUnderTest
    from pytest_hricdv.extra.schedules.scheduler import Scheduler
    from pytest_hricdv.run import Run
    from pytest_hricdv.testbench import Testbench


_noted: list[Scheduler] | None = None


def note_runs(noted: list[Scheduler]) -> None:
    """From now on this process notes what runs execute, and how they are scheduled, in a list."""
    global _noted
    _noted = noted


class ScheduleExecution(ExecutionFeature):
    """Orders the nodes of runs whose test has a schedule."""

    def surround(self, run: Run, code: CodeUnderTest, testbench: Testbench) -> AbstractContextManager[Any]:
        """See `ExecutionFeature`. Without a schedule nothing is instrumented, unless runs are noted."""
        if _noted is None and not run.test.schedule:
            return nullcontext()
        from pytest_hricdv.extra.schedules.scheduler import schedule_run  # of tests with a schedule only

        return schedule_run(run, code, testbench, _noted)


EXECUTION = ScheduleExecution()
