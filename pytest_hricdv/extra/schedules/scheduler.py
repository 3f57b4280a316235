"""`Scheduler`: holds nodes and delays messages in a run as its schedule says, and records what is executed when.

`ScheduleExecution` enters `instrument_points`, which instruments the code, and `schedule_run`, which makes a scheduler
for the run. `lanes` returns when each node ran, for the report.
"""

from __future__ import annotations

import asyncio
import builtins
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

from pytest_hricdv._base.record import Count, NotNegative, PlainRecord
from pytest_hricdv._base.schedule_record import DecisionKind
from pytest_hricdv.execution.faults import CodeUnderTest
from pytest_hricdv.execution.instrumented_code import instrument
from pytest_hricdv.extra.schedules.points import BETWEEN, HOOK, CodePoints, points_of
from pytest_hricdv.extra.schedules.records import NodeLane
from pytest_hricdv.generate.schedule import EACH_TIME, ScheduleDecision
from pytest_hricdv.run import Run
from pytest_hricdv.runtime import Kernel, Node
from pytest_hricdv.runtime.virtual.deadlocks import EndlessWait, find_deadlocks, find_endless_waits
from pytest_hricdv.runtime.virtual.thread_pool import WORK

MAX_STEPS = 200_000
"""Maximum number of recorded executions of code points, which take some 20 MB; a run of the table has some 10,000."""

MAX_CHOICES = 10_000
"""Maximum number of recorded choices between ready nodes, and of recorded messages."""

AROUND_S = 1.0
"""How long before and after a decision (s) switches between nodes are kept: people and robots react within it."""

MAX_SWITCHES = 500
"""Maximum number of kept switches of a run: a busy second of ten threads."""

US_PER_S = 1_000_000


PointStep = tuple[int, int, int]
"""An executed point: the number of the point, that of the thread or task of asyncio (from 0), and the time (us,
simulated)."""


class HeldNode(PlainRecord, frozen=True, kw_only=True):
    """The effect of one decision.

    Args:
        kind: the kind of the decision.
        place: where the node waited; of a message its topic.
        node: the node that waited; of a message its sender.
        time_s: when (s).
        for_s: for how long (s).
        between: what other nodes of the code executed meanwhile: the place, and the node's name.
        steps: how many steps the run had executed before, and at the end.
        choices: the same of choices between what was ready.
    """

    kind: DecisionKind = "preemption"
    place: str
    node: str
    time_s: NotNegative
    for_s: NotNegative
    between: tuple[tuple[str, str], ...] = ()
    steps: tuple[Count, Count] = (0, 0)
    choices: tuple[Count, Count] = (0, 0)

    def spans(self, wait: EndlessWait) -> bool:
        """Whether a wake-up came in vain while it held a node up, which then began to wait."""
        end_s = self.time_s + self.for_s
        return (
            wait.node == self.node
            and wait.unheard_s is not None
            and self.time_s <= wait.unheard_s <= end_s
            and abs(wait.since_s - end_s) < 1 / US_PER_S
        )


@dataclass
class Scheduler:
    """Carries out the decisions of a schedule in one run, as instrumented code asks for them.

    Args:
        stop: called when a node is about to be held up.
    """

    kernel: Kernel
    code: CodeUnderTest
    decisions: Sequence[ScheduleDecision]
    points: CodePoints
    stop: Callable[[str], None] | None = None
    steps: list[PointStep] = field(default_factory=list)
    nodes: list[int] = field(default_factory=list)
    """Of each thread, the number of its node, or of the call of a pool's node; tasks of one loop are in one."""
    names: list[str] = field(default_factory=list)
    """Of each thread, the name of its node."""
    choices: list[tuple[int, int]] = field(default_factory=list)
    """How many nodes, callbacks or waiters were ready, each time that one of several had to go first; how many steps
    the run had executed before."""
    messages: list[tuple[int, str]] = field(default_factory=list)
    """When each message of the bus arrives (us of simulated time), and its topic."""
    is_deadlock: bool = False
    """Whether nodes wait for locks of each other when the run is over."""
    waits: list[str] = field(default_factory=list)
    """Of nodes that wait without end when the run is over, a sentence each."""
    held_up: list[HeldNode] = field(default_factory=list)
    _counts: dict[str, int] = field(default_factory=dict)
    """How often a place with a decision was executed, and a topic published."""
    _arrivals: dict[tuple[str, str], int] = field(default_factory=dict)
    """Sender and topic -> when its last message arrives (us): none overtakes another one."""
    _ran: Node | None = None
    """The node that has control, if it has executed a statement since it got it."""
    _waiting: list[Node] = field(default_factory=list)
    """Held up until another node has run."""
    _held: int = 0
    """Number of nodes that a decision holds up."""
    _meanwhile: list[tuple[str, str]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._places = self.points.places
        self._at = {(entry.place, entry.occurrence): entry for entry in self.decisions if entry.place}
        self._picks = {entry.occurrence: entry.choice for entry in self.decisions if entry.kind == "order"}

    def hooks(self) -> dict[str, Callable[..., object]]:
        """What instrumented code calls: before a statement, and with the value that it is about to write."""
        kernel, code, steps, places, nodes = self.kernel, self.code, self.steps, self._places, self.nodes
        names, add = self.names, steps.append
        running_loop, current_task = asyncio._get_running_loop, asyncio.current_task
        decided = {place for place, _ in self._at}
        special = frozenset(number for number, place in enumerate(places) if place in decided)
        threads: dict[tuple[Node | None, object, object], int] = {}
        numbers: dict[tuple[Node | None, object], int] = {}

        def reach(point: int) -> None:
            node = kernel.inside
            loop = running_loop()
            thread = node, node and node.own.get(WORK), None if loop is None else current_task(loop)
            number = threads.get(thread)
            if number is None:
                number = threads[thread] = len(nodes) if code.has(kernel.own_node()) else -1
                if number >= 0:
                    nodes.append(numbers.setdefault(thread[:2], len(numbers)))
                    names.append(node.name if node else "")
            if number < 0 or node is None:
                return
            if point in special:
                self._decide(node, places[point])
            self._ran = node
            if self._held:
                self._meanwhile.append((places[point], node.name))
            if len(steps) < MAX_STEPS:
                add((point, number, kernel.now_us))

        def write(point: int, value: object, read: object = None, operation: str = "") -> object:
            written = calculate_written(point, value, read, operation)
            reach(point)
            return written

        return {HOOK: reach, BETWEEN: write}

    def _decide(self, node: Node, place: str) -> None:
        number = self._counts[place] = self._counts.get(place, 0) + 1
        decision = self._at.get((place, number)) or self._at.get((place, EACH_TIME))
        if decision is not None:
            if self.stop is not None:
                self.stop(f"{node.name} waits before {place} ({decision.kind})")
            self._hold(node, decision)

    def _hold(self, node: Node, decision: ScheduleDecision) -> None:
        began_s, number = self.kernel.now_s, len(self._meanwhile)
        steps, choices = len(self.steps), len(self.choices)
        if decision.kind == "preemption":
            self._waiting.append(node)
        self._held += 1
        try:
            self.kernel.block(decision.delay_s)
        finally:
            self._held -= 1
            if node in self._waiting:
                self._waiting.remove(node)
        held = HeldNode(
            kind=decision.kind,
            place=decision.place,
            node=node.name,
            time_s=round(began_s, 6),
            for_s=round(self.kernel.now_s - began_s, 6),
            between=tuple(dict.fromkeys(self._meanwhile[number:])),
            steps=(steps, len(self.steps)),
            choices=(choices, len(self.choices)),
        )
        self.held_up.append(held)

    def carry(self, sender: str, topic: str) -> float:
        """How long a message is on its way (s)."""
        number = self._counts[topic] = self._counts.get(topic, 0) + 1
        decision = self._at.get((topic, number))
        delay_s = decision.delay_s if decision else 0.0
        now_us = self.kernel.now_us
        arrival_us = max(now_us + round(delay_s * US_PER_S), self._arrivals.get((sender, topic), 0))
        self._arrivals[sender, topic] = arrival_us
        if len(self.messages) < MAX_CHOICES:
            self.messages.append((arrival_us, topic))
        if decision:
            time_s = round(self.kernel.now_s, 6)
            late = HeldNode(kind="delivery", place=topic, node=sender, time_s=time_s, for_s=round(delay_s, 6))
            self.held_up.append(late)
        return (arrival_us - now_us) / US_PER_S

    def pick(self, count: int) -> int:
        """The index of the node, callback or waiter that goes first, of `count` that are ready."""
        if len(self.choices) < MAX_CHOICES:
            self.choices.append((count, len(self.steps)))
        chosen = self._picks.get(len(self.choices), 0)
        return chosen if chosen < count else 0

    def note_waits(self) -> None:
        """The run is over: who waits without end, and for what."""
        nodes = [node for node in self.kernel.nodes if self.code.has(node)]
        self.is_deadlock = any(True for _ in find_deadlocks(nodes))
        for wait in find_endless_waits(nodes):
            begin = f"{wait.node} waits without end at {wait.place}"
            if wait.holder is not None:
                self.waits.append(f"{begin} for a lock that {wait.holder} holds")
            elif wait.unheard_s is not None and any(held.spans(wait) for held in self.held_up):
                self.waits.append(f"lost wake-up: {begin}, after it was woken at {wait.unheard_s:.6g} s in vain")
            else:
                self.waits.append(begin)

    def end_holds(self, node: Node) -> None:
        """A node has given control back: if it executed anything, who waited for another one to run continues."""
        if self._ran is node:
            self._ran = None
            for waiting in [other for other in self._waiting if other is not node]:
                self._waiting.remove(waiting)
                self.kernel.wake(waiting)


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
def instrument_points(packages: Sequence[str]) -> Iterator[CodePoints]:
    """Instrument code for a while, for any number of runs."""
    points, files = points_of(packages)
    with instrument(files, {HOOK: lambda _: None, BETWEEN: calculate_written}):
        yield points


def calculate_written(_: int, value: object, read: object = None, operation: str = "") -> object:
    """What a statement writes that has read something."""
    return _OPERATIONS[operation](read, value) if operation else value


@contextmanager
def schedule_run(
    run: Run, code: CodeUnderTest, points: CodePoints, stop: Callable[[str], None] | None = None
) -> Iterator[Scheduler]:
    """Carry out the schedule of a run's test while it runs, in code instrumented with these points."""
    scheduler = Scheduler(run.kernel, code, run.test.schedule, points, stop)
    run.kernel.pick, run.kernel.notice_return = scheduler.pick, scheduler.end_holds
    run.bus.transport = scheduler.carry
    before_end = run.before_end or (lambda: None)

    def end() -> None:
        before_end()
        scheduler.note_waits()

    run.before_end = end
    vars(builtins).update(scheduler.hooks())
    yield scheduler


def lanes(scheduler: Scheduler) -> tuple[NodeLane, ...]:
    """Of each node that executed code then, in the order in which they began."""
    held = [entry for entry in scheduler.held_up if entry.kind != "delivery"]
    times = [(entry.time_s - AROUND_S, entry.time_s + entry.for_s + AROUND_S) for entry in scheduler.held_up]
    switches: list[tuple[str, float, str]] = []
    before = -1
    for point, thread, time_us in scheduler.steps:
        time_s = time_us / US_PER_S
        if thread != before and any(begin_s <= time_s <= end_s for begin_s, end_s in times):
            switches.append((scheduler.names[thread], time_s, scheduler.points.places[point]))
        before = thread
    shown = switches[:MAX_SWITCHES]
    return tuple(
        NodeLane(
            node=name,
            switches=tuple((time_s, place) for node, time_s, place in shown if node == name),
            held=tuple((entry.time_s, entry.time_s + entry.for_s, entry.place) for entry in held if entry.node == name),
        )
        for name in dict.fromkeys(scheduler.names)
    )
