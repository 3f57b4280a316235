"""Runs a test under its schedule, if it has one: the code's nodes go on in another order than the usual one."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any

from pytest_hricdv.execution.execution_feature import ExecutionFeature

if TYPE_CHECKING:
    from pytest_hricdv.execution.faults import CodeUnderTest
    from pytest_hricdv.extra.schedules.points import CodePoints
    from pytest_hricdv.extra.schedules.scheduler import Scheduler
    from pytest_hricdv.run import Run
    from pytest_hricdv.testbench import Testbench


_HERE = Path(__file__).parent


@dataclass
class Instrumentation:
    """Where all runs of this process are recorded: the points of the code, and the scheduler of the last run."""

    points: CodePoints | None = None
    last: Scheduler | None = None
    is_debugged: bool = False
    """Whether a debugger stops where a node is about to be held up."""
    quit: BaseException | None = None
    """Raised after the run if a person quit the debugger: raised there, it would look like an error of the code."""


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
        stop = _stop if INSTRUMENTATION.is_debugged and INSTRUMENTATION.points is None else None
        INSTRUMENTATION.last = stack.enter_context(schedule_run(run, code, points, stop))
        yield


def _stop(header: str) -> None:
    """Open pdb at the statement that waits, in the frame that called the hook."""
    import pytest
    from _pytest.debugging import pytestPDB

    if INSTRUMENTATION.quit is not None:
        return
    frame: FrameType | None = sys._getframe()
    while frame is not None and Path(frame.f_code.co_filename).parent == _HERE:
        frame = frame.f_back
    try:
        pdb = pytestPDB._init_pdb("hri-schedules", header=f"{header}; c continues")  # type: ignore[no-untyped-call]
        pdb.reset()
        pdb.interaction(frame, None)
    except pytest.exit.Exception as error:
        INSTRUMENTATION.quit = error


EXECUTION = ScheduleExecution()
