"""`ScheduleExecution`: runs a test under its schedule, if it has one, so that nodes resume in another order than usual.

It is the `EXECUTION` of this feature (see `registry`); each run of a test calls its `surround`. `INSTRUMENTATION` has
the scheduler of the last run, from which `SchedulesFeature` takes when nodes ran.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any

from pytest_hricdv.execution.execution_feature import ExecutionFeature
from pytest_hricdv.generate import GenerateError

if TYPE_CHECKING:
    from pytest_hricdv.execution.faults import CodeUnderTest
    from pytest_hricdv.extra.schedules.points import CodePoints
    from pytest_hricdv.extra.schedules.scheduler import Scheduler
    from pytest_hricdv.generate.schedule import ScheduleDecision
    from pytest_hricdv.run import Run
    from pytest_hricdv.testbench import Testbench


_HERE = Path(__file__).parent


@dataclass
class Instrumentation:
    """The state of this process: the points of the code if all its runs are instrumented, and the last scheduler."""

    points: CodePoints | None = None
    last: Scheduler | None = None
    is_debugged: bool = False
    """Whether a debugger stops when a node is about to be held up (`--pdb`)."""
    quit: BaseException | None = None
    """Raised after the run if a person quit the debugger; raised at once, it would look like an error of the code."""


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
    from pytest_hricdv.execution.faulty_import import FaultyImport
    from pytest_hricdv.extra.schedules.scheduler import instrument_points, schedule_run

    # A mutant may lack the statement, and runs of a search are made of what earlier ones executed.
    is_mutant = any(isinstance(finder, FaultyImport) for finder in sys.meta_path)
    is_given = INSTRUMENTATION.points is None and not is_mutant
    with ExitStack() as stack:
        points = INSTRUMENTATION.points or stack.enter_context(instrument_points(testbench.code))
        stop = _stop if INSTRUMENTATION.is_debugged and INSTRUMENTATION.points is None else None
        INSTRUMENTATION.last = stack.enter_context(schedule_run(run, code, points, stop))
        yield
        if is_given:
            _check_places(run.test.schedule, points)


def _check_places(schedule: Iterable[ScheduleDecision], points: CodePoints) -> None:
    """Refuse a decision at what is no statement any more: without it, the run had the usual order."""
    places = points.places
    for decision in schedule:
        if decision.kind in ("preemption", "delay") and decision.place not in places:
            raise GenerateError(
                f"the schedule of the test has a {decision.kind} at {decision.place}, where nothing can wait; expected "
                "the file and line of a statement of the code under test that uses data of several threads"
            )


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
