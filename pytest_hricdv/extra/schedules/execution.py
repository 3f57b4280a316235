"""Schedules in the execution of tests: a test that has one runs with it."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any

from pytest_hricdv.execution.execution_feature import ExecutionFeature

if TYPE_CHECKING:
    from pytest_hricdv.execution.faults import CodeUnderTest
    from pytest_hricdv.extra.schedules.scheduler import Scheduler
    from pytest_hricdv.run import Run
    from pytest_hricdv.testbench import Testbench


class ScheduleExecution(ExecutionFeature):
    """Orders the nodes of runs whose test has a schedule."""

    noting: list[Scheduler] | None = None
    """Where a process that searches for schedules has what its runs executed; None in others, which note nothing."""

    def surround(self, run: Run, code: CodeUnderTest, testbench: Testbench) -> AbstractContextManager[Any]:
        """See `ExecutionFeature`. Without a schedule nothing is instrumented."""
        if self.noting is None and not run.test.schedule:
            return nullcontext()
        from pytest_hricdv.extra.schedules.scheduler import schedule_run  # of tests with a schedule only

        return schedule_run(run, code, testbench, self.noting)


EXECUTION = ScheduleExecution()
