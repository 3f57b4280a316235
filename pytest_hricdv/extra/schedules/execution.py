"""Schedules in the execution of tests: runs a test under its schedule, if it has one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pytest_hricdv.execution.execution_feature import ExecutionFeature

if TYPE_CHECKING:
    from pytest_hricdv.execution.faults import CodeUnderTest
    from pytest_hricdv.extra.schedules.points import CodePoints
    from pytest_hricdv.extra.schedules.scheduler import Scheduler
    from pytest_hricdv.run import Run
    from pytest_hricdv.testbench import Testbench


@dataclass
class Instrumentation:
    """Of this process, if all of its runs are noted: the points of the code, and what scheduled the last run."""

    points: CodePoints | None = None
    last: Scheduler | None = None


INSTRUMENTATION = Instrumentation()


class ScheduleExecution(ExecutionFeature):
    """Orders the nodes of runs whose test has a schedule."""

    def surround(self, run: Run, code: CodeUnderTest, testbench: Testbench) -> AbstractContextManager[Any]:
        """See `ExecutionFeature`. Without a schedule nothing is instrumented, unless all runs are."""
        if INSTRUMENTATION.points is None and not run.test.schedule:
            return nullcontext()
        return _schedule(run, code, testbench)


@contextmanager
def _schedule(run: Run, code: CodeUnderTest, testbench: Testbench) -> Iterator[None]:
    from pytest_hricdv.extra.schedules.scheduler import instrument_points, schedule_run

    with ExitStack() as stack:
        points = INSTRUMENTATION.points or stack.enter_context(instrument_points(testbench.code))
        INSTRUMENTATION.last = stack.enter_context(schedule_run(run, code, points))
        yield


EXECUTION = ScheduleExecution()
