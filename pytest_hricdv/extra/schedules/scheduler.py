"""The scheduler: carries out the decisions of a schedule in a run, and records what was executed when."""

from __future__ import annotations

import ast
import asyncio
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from pytest_hricdv.coverage.source_files import ModuleFile, module_files
from pytest_hricdv.execution.faults import CodeUnderTest
from pytest_hricdv.execution.instrumented_code import instrument
from pytest_hricdv.extra.schedules.points import BETWEEN, HOOK, CodePoints, DataAccess
from pytest_hricdv.generate.schedule import EACH_TIME, ScheduleDecision
from pytest_hricdv.run import Run
from pytest_hricdv.runtime import Kernel, Node
from pytest_hricdv.runtime.virtual.thread_pool import WORK
from pytest_hricdv.testbench import Testbench

MAX_STEPS = 200_000
"""Number of executions of code points that are recorded, which takes some 10 MB; a run of the table has some 10,000."""

MAX_CHOICES = 10_000
"""Number of choices between ready nodes that are recorded."""


@dataclass(frozen=True)
class PointStep:
    """A point that was executed.

    Args:
        point: its number in the points.
        number: which execution of its place this is, from 1.
        thread: of the code, or task of asyncio, by their numbers from 0.
        node: that it is in; tasks of one loop are in one node.
        time_s: when (s of simulated time).
    """

    point: int
    number: int
    thread: int
    node: int
    time_s: float


@dataclass(frozen=True)
class ReadyChoice:
    """Several nodes, or callbacks of an executor, were ready: how many, and when (s of simulated time)."""

    ready: int
    time_s: float


@dataclass(frozen=True)
class HoldRecord:
    """A decision that was carried out.

    Args:
        decision: of the schedule.
        node: that was held up, its name.
        time_s: when (s of simulated time).
        for_s: for how long (s).
        meanwhile: places that other nodes of the code executed meanwhile, each with the node's name.
    """

    decision: ScheduleDecision
    node: str
    time_s: float
    for_s: float = 0.0
    meanwhile: tuple[tuple[str, str], ...] = ()


@dataclass
class Scheduler:
    """What instrumented code asks in a run.

    Args:
        kernel: of the run.
        code: whose nodes are scheduled.
        decisions: of the schedule.
        points: of the instrumented code.
        notes: whether what is executed is noted.
    """

    kernel: Kernel
    code: CodeUnderTest
    decisions: Sequence[ScheduleDecision]
    points: CodePoints
    notes: bool = False
    steps: list[PointStep] = field(default_factory=list)
    choices: list[ReadyChoice] = field(default_factory=list)
    held_up: list[HoldRecord] = field(default_factory=list)
    _counts: dict[str, int] = field(default_factory=dict)
    _nodes: dict[tuple[Node, object], int] = field(default_factory=dict)
    """Nodes, and calls of a pool's nodes -> their numbers."""
    _threads: dict[tuple[Node, object, object], int] = field(default_factory=dict)
    _ran: set[Node] = field(default_factory=set)
    """Nodes that have executed a statement since they got control."""
    _waiting: list[Node] = field(default_factory=list)
    """Held up until another node has run."""
    _meanwhile: list[tuple[str, str]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._at = {(entry.place, entry.number): entry for entry in self.decisions if entry.kind != "order"}
        self._picks = {entry.number: int(entry.value) for entry in self.decisions if entry.kind == "order"}

    def reach(self, point: int) -> None:
        """A statement is about to be executed."""
        node = self.kernel.own_node()
        if node is None or not self.code.has(node):
            return
        place = self.points.places[point]
        number = self._counts[place] = self._counts.get(place, 0) + 1
        decision = self._at.get((place, number)) or self._at.get((place, EACH_TIME))
        if decision is not None:
            self._hold(node, decision)
        self._ran.add(node)
        if self._waiting:
            self._meanwhile.append((place, node.name))
        if self.notes and len(self.steps) < MAX_STEPS:
            call = node, node.own.get(WORK)
            thread = self._threads.setdefault((*call, _task()), len(self._threads))
            here = self._nodes.setdefault(call, len(self._nodes))
            self.steps.append(PointStep(point, number, thread, here, self.kernel.now_s))

    def write(self, point: int, value: object, read: object = None, operation: str = "") -> object:
        """The value that a statement is about to write, which has read what it needs."""
        if operation:
            operate: Callable[[object, object], object] = _OPERATIONS[operation]
            value = operate(read, value)
        self.reach(point)
        return value

    def _hold(self, node: Node, decision: ScheduleDecision) -> None:
        began_s, number = self.kernel.now_s, len(self._meanwhile)
        if decision.kind == "hold":
            self._waiting.append(node)
        try:
            self.kernel.block(decision.value)
        finally:
            if node in self._waiting:
                self._waiting.remove(node)
        self.held_up.append(
            HoldRecord(
                decision,
                node.name,
                began_s,
                self.kernel.now_s - began_s,
                tuple(dict.fromkeys(self._meanwhile[number:])),
            )
        )

    def pick(self, count: int) -> int:
        """Which of so many nodes or callbacks that are ready goes first."""
        self.choices.append(ReadyChoice(count, self.kernel.now_s))
        chosen = self._picks.get(len(self.choices), 0)
        return chosen if chosen < count else 0

    def end_holds(self, node: Node) -> None:
        """A node has given control back: if it executed anything, who waited for another one to run goes on."""
        if node in self._ran:
            self._ran.discard(node)
            for waiting in [other for other in self._waiting if other is not node]:
                self._waiting.remove(waiting)
                self.kernel.wake(waiting)


def _task() -> object:
    """The task of asyncio that runs; None outside of one."""
    loop = asyncio._get_running_loop()
    return None if loop is None else asyncio.current_task(loop)


_OPERATIONS: Mapping[str, Callable[..., object]] = {
    "Add": operator.iadd,
    "Sub": operator.isub,
    "Mult": operator.imul,
    "Div": operator.itruediv,
    "FloorDiv": operator.ifloordiv,
    "Mod": operator.imod,
    "Pow": operator.ipow,
    "MatMult": operator.imatmul,
    "LShift": operator.ilshift,
    "RShift": operator.irshift,
    "BitAnd": operator.iand,
    "BitOr": operator.ior,
    "BitXor": operator.ixor,
}


@contextmanager
def schedule_run(
    run: Run, code: CodeUnderTest, testbench: Testbench, noting: list[Scheduler] | None = None
) -> Iterator[Scheduler]:
    """Carry out the schedule of a run's test while it runs.

    Args:
        run: of the test.
        code: its nodes of the code under test.
        testbench: that it is of.
        noting: gets what the run executes.
    """
    points, decisions = CodePoints(), run.test.schedule
    files = [
        (file.path, file.path.read_text(encoding="utf-8"), points.instrument(name_of(file)).visit)
        for file in module_files(testbench.code, Path())
        if not file.problem
    ]
    scheduler = Scheduler(run.kernel, code, decisions, points, noting is not None)
    if noting is not None:
        noting.append(scheduler)
    run.kernel.pick, run.kernel.notice_return = scheduler.pick, scheduler.end_holds
    with instrument(files, {HOOK: scheduler.reach, BETWEEN: scheduler.write}):
        yield scheduler


def read_starts(packages: Sequence[str]) -> dict[str, str]:
    """Where functions and the bodies of loops begin: place -> what begins there."""
    points = CodePoints()
    for file in module_files(packages, Path()):
        if not file.problem:
            points.instrument(name_of(file)).visit(ast.parse(file.path.read_text(encoding="utf-8")))
    return points.starts


def name_of(file: ModuleFile) -> str:
    """`controller/robot.py` of the module `controller.robot`, wherever pytest was started."""
    folder = file.module.replace(".", "/")
    return f"{folder}/__init__.py" if file.path.name == "__init__.py" else f"{folder}.py"


def accesses(points: CodePoints) -> dict[str, DataAccess]:
    """Place -> what its statements read and write."""
    made: dict[str, DataAccess] = {}
    for place, access in zip(points.places, points.accesses, strict=True):
        before = made.get(place, DataAccess())
        made[place] = DataAccess(before.reads | access.reads, before.writes | access.writes)
    return made
