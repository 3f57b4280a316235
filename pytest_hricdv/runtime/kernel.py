"""Virtual time: the `Kernel` of a run resumes its nodes, which are greenlets, in the order of their due times.

A `Node` is ordinary blocking Python. When it sleeps or waits, control returns to the `Kernel`, which advances the world
to the next due time and resumes the nodes that are due then. Nothing runs in parallel and nothing reads a wall clock,
so a run depends only on its inputs. `Run`, the bus and `runtime.virtual` make nodes wait by the kernel.

Time is counted in whole microseconds, so sums of durations are exact, and nodes that are due at the same time stay so.
Nodes that are due at the same time are resumed in the order in which they began to wait.
"""

from __future__ import annotations

import ctypes
import math
import sys
import threading
from collections import deque
from collections.abc import Callable
from contextvars import Context, copy_context
from types import FrameType
from typing import NoReturn

from greenlet import GreenletExit, greenlet

from pytest_hricdv._base.error_text import error_text, text_of
from pytest_hricdv.runtime.node_error import KernelError, NodeError, TerminalInterrupt, what_never_began, word_of
from pytest_hricdv.runtime.source_location import place_of
from pytest_hricdv.runtime.supervision import STUCK_AFTER_S, Supervision
from pytest_hricdv.runtime.timeouts import PRUNE_AT, Timeouts
from pytest_hricdv.runtime.world import World, advance_world

US_PER_S = 1_000_000
"""Microseconds per second. A day has far fewer than 2**53, so the float `now_s` distinguishes all of them."""

POLLS = 100
"""Polls of a subscription at one instant after which time passes, in runs in which a poll takes time."""

BUSY_READS, READS_A_MS = 1_000, 100
"""A loop that reads a clock 1,000 times at one instant waits for time to pass. From then on, 100 reads take 1 ms of
simulated time, as a loop in Python takes on a robot's small computer: so the loop ends within 1 ms of its due time."""

READS_A_LOOK = 100
"""Number of clock reads that take as long (1 ms) as `rclpy` takes to check all that it waits for and find nothing."""

MAX_STEPS = 5_000
"""Most steps of a node, from one wait to the next, in 0.02 s of simulated time: this is a loop of 250 kHz, 25 times as
fast as the loops of the fastest controllers."""

_COUNTED_US = US_PER_S // 50

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all


class _NodeGreenlet(greenlet):
    """A greenlet that knows its node."""

    node: Node


def current_node() -> Node | None:
    """The node, of whichever kernel, that runs in this thread; None outside of a node."""
    here = greenlet.getcurrent()
    return here.node if isinstance(here, _NodeGreenlet) else None


def _copy_context() -> Context:
    """The values of context variables here. The context of `decimal` is one of its own: code changes it in place."""
    context = copy_context()
    if decimal := sys.modules.get("decimal"):
        context.run(lambda: decimal.setcontext(decimal.getcontext().copy()))
    return context


class Node:
    """One blocking activity; created by `Kernel.spawn`."""

    def __init__(self, kernel: Kernel, name: str, body: Callable[[], None]) -> None:
        self.kernel = kernel
        self.name = name
        self.body = body
        self.ended = False
        self.leaving: list[Callable[[], Callable[[], None]]] = []
        """Called when it blocks; each returns a function to call when it resumes. For Python's state per thread."""
        self.wrap_thread: Callable[[Callable[[], None], bool], Callable[[], None]] = lambda body, daemon: body
        """Wraps the body of a thread that it starts, for instance so that it is measured."""
        self.own: dict[str, object] = {}
        """State of replaced Python modules for this node, such as its threads and its event loop."""
        self.tasks = 0
        """How many tasks of asyncio its first one has started, and those."""
        self.greenlet = _NodeGreenlet(body)
        self.greenlet.node = self
        if current_node() is None:  # as a program's main thread; its other threads begin without values
            self.greenlet.gr_context = _copy_context()
        self.wait = 0  # number of the current wait; heap entries of earlier waits are stale
        self.counted = 0  # of these, when its steps were counted last
        self.woken = False
        self.abandoned = False
        """It catches whatever is raised in it, and is left where it is."""
        self.blocked_s = 0.0
        """When the node began to wait (s of simulated time), if it waits."""
        self.blocked = False  # it waits, and is not among those that continue at this instant

    def leave_for_ever(self) -> None:
        """It is never resumed again: it is left where it is."""
        self.ended = self.abandoned = True
        if self.kernel.inside is self:  # one that waits has left already
            for leave in self.leaving:
                leave()
        # Never freed, not even when the interpreter ends: greenlet would raise in it, and it would continue.
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(self.greenlet))

    @property
    def frame(self) -> FrameType | None:
        """Its innermost frame, while it waits; None while it runs, and when it has ended."""
        return self.greenlet.gr_frame


class Kernel:
    """Runs nodes in virtual time, with an optional world that advances while they wait.

    >>> kernel = Kernel()
    >>> _ = kernel.spawn("a", lambda: (kernel.sleep(1.5), print(kernel.now_s)))
    >>> kernel.run(limit_s=10.0)
    1.5
    'idle'
    """

    # 100,000 (chosen) polls take 10 ms and as many resumes 0.3 s: a loop that never sleeps is found at once.
    def __init__(self, *, max_resumes_at_one_instant: int = 100_000, stuck_after_s: float | None = None) -> None:
        self.now_us = 0
        self.last_messages: dict[str, object] = {}
        """Sender -> its last message; error messages use it to say where a node hangs."""
        self.supervision = Supervision(self, STUCK_AFTER_S if stuck_after_s is None else stuck_after_s)
        self._runs = False
        self.inside: Node | None = None
        """The node that has control."""
        self.returns = 0
        """How often control has come back."""
        self.polls_take_s = 0.0
        """Simulated time that passes after `POLLS` polls at one instant; 0: none, such a loop is an error."""
        self._polls = self._reads = 0  # at the present instant
        self._read_until_us = -1  # when the last loop that waited for a clock read it again
        self._polled_at = ""  # the line of the first poll too many
        self.lost_errors: list[str] = []
        """Errors that ended background work that nobody waited for, a sentence each."""
        self.unclaimed: list[Callable[[], str]] = []
        """Called when the run is over; each returns a sentence about an unclaimed error, or an empty string."""
        self.world: World | None = None
        self.after_steps: list[Callable[[], None]] = []
        """Called after each step of the world, for waits for a time at which no step ends."""
        self.virtual: frozenset[str] = frozenset()
        """Python's blocking APIs that take virtual time, see `pytest_hricdv.runtime.virtual`."""
        self.code: tuple[str, ...] = ()
        """The packages in which they do."""
        self.own: dict[str, object] = {}
        """State of replaced libraries for the run, such as the ROS graph."""
        self.trespasses: list[str] = []
        """Forbidden acts of threads that are not nodes, a sentence each."""
        self.refusals: list[KernelError] = []
        """Errors that were raised in nodes because they wait in real time, whether or not the code caught them."""
        self.notice_wake: Callable[[Node], None] | None = None
        """Called with each node that is woken."""
        self.notice_wait: Callable[[Node, float | None], None] | None = None
        """Called with each node that begins to wait, and how long at most (s)."""
        self.pick: Callable[[int], int] | None = None
        """Choose which of this many ready nodes or callbacks goes first; None for the first one. See `choose`."""
        self.notice_return: Callable[[Node], None] | None = None
        """Called with each node that has given control back."""
        self._look: Callable[[], None] = lambda: None
        self._look_us: float = math.inf
        self._look_period_us = 0.0
        self._thread = threading.get_ident()
        self._hub: greenlet | None = None
        self._nodes: list[Node] = []
        self._prune_at = PRUNE_AT
        self._timeouts: Timeouts[Node] = Timeouts()
        self._ready: deque[Node] = deque()
        self._stop: str | None = None
        self._count_us = _COUNTED_US
        self._instants = 0  # since steps were counted
        self._resumes = 0  # at the present instant
        self._max_resumes = max_resumes_at_one_instant

    @property
    def now_s(self) -> float:
        """Simulated time, in seconds."""
        return self.now_us / US_PER_S

    def count_poll(self) -> None:
        """Count a call that returns to the node without blocking, such as a poll of a queue or of the clock.

        Raises:
            KernelError: too many polls without time passing: a loop that never sleeps would never end.
        """
        self._polls += 1
        if self.polls_take_s and self._polls >= POLLS:
            self.sleep(self.polls_take_s)
        if self._polls > self._max_resumes:
            if self._polls == self._max_resumes + 1:  # what cleans up afterwards may poll, too
                self._polled_at = place_of(sys._getframe(1))
            problem = f"{self._max_resumes} polls without time passing, at {self._polled_at}: a loop must sleep"
            raise KernelError(problem + self.node_info())

    def count_clock_read(self) -> None:
        """Count a reading of a clock: a loop that only reads one, `while time.time() < end`, lets time pass.

        Raises:
            KernelError: as `count_poll`, for loops that do not end with a time.
        """
        self._reads += 1
        if self._reads >= (READS_A_MS if self._read_until_us == self.now_us else BUSY_READS):
            self.sleep(1e-3)
            self._read_until_us = self.now_us
        self.count_poll()

    def count_look(self) -> None:
        """Count a look for work that found none: a loop that looks until a time, and reads a clock, lets time pass.

        Raises:
            KernelError: as `count_poll`, for loops that do not end with a time.
        """
        if self._reads:
            self._reads += READS_A_LOOK
        self.count_poll()

    def count_work(self) -> None:
        """Count a look for work that found some. One that always finds some lets others have their turn now and then.

        Raises:
            KernelError: as `count_poll`.
        """
        self.count_poll()
        if self._polls % BUSY_READS == 0:
            self.sleep(0.0)

    def spawn(self, name: str, body: Callable[[], None]) -> Node:
        """Start `body` as a node at the present simulated instant."""
        node = Node(self, name, body)
        if self._hub is not None:  # a node that is started by another node returns to the kernel when it ends
            node.greenlet.parent = self._hub
        self._nodes.append(node)
        if len(self._nodes) > self._prune_at:
            self._nodes = [node for node in self._nodes if not node.ended]
            self._prune_at = max(PRUNE_AT, 2 * len(self._nodes))
        self._ready.append(node)
        return node

    def sleep(self, duration_s: float) -> None:
        """Block the calling node for `duration_s` seconds of simulated time.

        Raises:
            KernelError: called from outside a node, or a duration that is negative or not finite.
        """
        self.block(duration_s)

    def block(self, timeout_s: float | None = None) -> bool:
        """Block the calling node until `wake`, at most `timeout_s`; True when it was woken, False on time-out."""
        node = self.current()
        node.wait += 1
        node.woken = False
        if timeout_s is not None:
            if not (math.isfinite(timeout_s) and timeout_s >= 0):
                raise KernelError(f"{node.name} at {self.now_s:.3f} s: cannot wait for {timeout_s!r} s")
            # A wait of less than a microsecond takes one, otherwise a loop that waits for a time would never end.
            self._timeouts.add(self.now_us + max(round(timeout_s * US_PER_S), int(timeout_s > 0)), node)
        assert self._hub is not None
        if self.notice_wait is not None:
            self.notice_wait(node, timeout_s)
        node.blocked = True
        node.blocked_s = self.now_s
        # Left from the first to the last and entered in the opposite order, as context managers are.
        going_on = [leave() for leave in node.leaving]
        try:
            self._hub.switch()
        finally:
            for go_on in reversed(going_on):
                go_on()
        return node.woken

    def wake(self, node: Node) -> None:
        """Make a blocked node runnable at the present instant.

        A node whose time-out is at this instant and that was not resumed yet is woken as well: `block` returns True.
        """
        if node.ended:
            return
        if self.notice_wake is not None:
            self.notice_wake(node)
        node.woken = True
        self._make_runnable(node)

    def require_own_thread(self, deed: str) -> None:
        """Refuse what another thread than that of the run does: when it does so is up to the system.

        Args:
            deed: what it does.

        Raises:
            SystemExit: the caller is in another thread, which ends; the run has it among its `trespasses`.
        """
        if threading.get_ident() == self._thread:
            return
        self.trespass(
            f"{place_of(sys._getframe(1))}: {deed} at {self.now_s:.3f} s from thread "
            f"{threading.current_thread().name}, which is not part of the run: let a node do it, or a thread of the "
            'code under test, with time=VirtualTime(apis=("threading",))'
        )

    def trespass(self, problem: str) -> NoReturn:
        """End the calling thread, which is none of the run; the run fails for it, because of no exception it would."""
        self.trespasses.append(problem)
        raise SystemExit(problem)

    def current(self) -> Node:
        """The running node. Raises KernelError outside of a node."""
        node = self.own_node()
        if node is None:
            raise KernelError("only a node may block: start the activity with Kernel.spawn")
        return node

    def own_node(self) -> Node | None:
        """The running node; None outside of a node."""
        node = current_node()
        return node if node is not None and node.kernel is self else None

    def stop(self, reason: str) -> None:
        """End the run once the present instant is over; `run` returns `reason`.

        Raises:
            KernelError: nothing has run yet.
        """
        if self._hub is None:
            raise KernelError(f"kernel.stop({reason!r}) before the run: expected a call by a node or the world")
        self._stop = self._stop or reason

    @property
    def is_running(self) -> bool:
        """Whether `run` is called."""
        return self._runs

    @property
    def is_stopped(self) -> bool:
        """Whether `stop` ended the last run."""
        return self._stop is not None

    def run(self, limit_s: float) -> str:
        """Run until a stop, until nothing is left to do, or until `limit_s` (absolute simulated time in seconds).

        Returns:
            The reason given to `stop`, "idle" when no node can ever run again, or "limit".

        Raises:
            NodeError: a node raised (its own exception is the cause), or nodes wake each other without end.
            KernelError: the limit is not finite.
        """
        if not math.isfinite(limit_s):
            raise KernelError(f"cannot run up to {limit_s!r} s: expected a finite time, in seconds")
        with self.supervision.watch():
            self._runs = True
            try:
                return self._run(limit_s)
            finally:
                self._runs = False

    def _run(self, limit_s: float) -> str:
        self._hub = greenlet.getcurrent()
        self._stop = None
        limit_us = round(limit_s * US_PER_S)
        while True:
            self._run_ready()
            if self.now_us >= self._look_us:
                self._look_us = self.now_us + self._look_period_us
                self._look()
            self._instants += 1
            if self.now_us >= self._count_us or self._instants > MAX_STEPS + 1:
                self._count_steps()
            if self._stop is not None:
                return self._stop
            due_us = self._timeouts.next_us()
            if due_us is None and self.world is None:
                return "idle"
            self._advance(limit_us if due_us is None else min(due_us, limit_us))
            if self.now_us >= limit_us and not self._ready and (due_us is None or due_us > limit_us):
                return "limit"
            for node in self._timeouts.pop(self.now_us):
                self._make_runnable(node)

    def _count_steps(self) -> None:
        """Raises NodeError for a node that waits for next to nothing, again and again; as soon as that is known."""
        is_over, self._instants = self.now_us >= self._count_us, 0
        if is_over:
            self._count_us = self.now_us + _COUNTED_US
        for node in self._nodes:
            waits = (node.wait - node.counted) // 2  # a wait has two numbers
            if is_over:
                node.counted = node.wait
            if waits > MAX_STEPS and not node.ended:
                problem = (
                    f"at {self.now_s:.3f} s: more than {MAX_STEPS:,} steps of it within 0.02 s, at "
                    f"{place_of(node.frame)}: sleep longer between two of them, or give timers a longer period"
                )
                raise NodeError(node.name, self.now_s, problem)

    def look_each(self, period_s: float, look: Callable[[], None]) -> None:
        """Let somebody look at the run each `period_s` of simulated time, between two steps of it, who may stop it."""
        self._look, self._look_period_us = look, period_s * US_PER_S
        self._look_us = self.now_us + self._look_period_us

    def wait_ends(self, began_by_s: float, ends_by_s: float) -> bool:
        """Whether a node has waited since `began_by_s`, and its time-out comes by `ends_by_s` (s of simulated time)."""
        ends_by_us = ends_by_s * US_PER_S
        return any(
            due_us <= ends_by_us and node.blocked_s <= began_by_s for due_us, node in self._timeouts.open_timeouts()
        )

    def skip(self, until_s: float) -> None:
        """Set the time to `until_s` after an idle run, in which nothing else can happen."""
        self.now_us = max(self.now_us, round(until_s * US_PER_S))

    def close(self) -> None:
        """End every node that is still blocked (their `finally` clauses run).

        Raises:
            NodeError: a node does not end; all others have.
        """
        self._hub = greenlet.getcurrent()
        failed: BaseException | None = None
        with self.supervision.watch():
            for node in self._nodes:
                if not node.ended and node.greenlet:
                    try:
                        self._enter(node, GreenletExit)
                    except BaseException as error:
                        if not (isinstance(error, (Exception, SystemExit)) or word_of(error)):
                            raise
                        failed = failed or error
                node.ended = True
        if failed is not None:
            raise failed

    def waits_for_ever(self, node: Node) -> bool:
        """Whether a node is blocked without a time-out: only another one can wake it."""
        return node.blocked and not any(pending is node for _, pending in self._timeouts.open_timeouts())

    @property
    def nodes(self) -> tuple[Node, ...]:
        """The nodes that have not ended, and some that have, in the order in which they were started."""
        return tuple(self._nodes)

    def abandon(self, error: BaseException) -> NoReturn:
        """Leave the running node where it is, for ever, and raise in what runs the kernel.

        Raises:
            KernelError: no node runs.
        """
        node = self.current()
        node.leave_for_ever()
        assert self._hub is not None
        self._hub.throw(error)
        raise error  # never reached

    def node_info(self) -> str:
        """The running node at the end of a message: its last message, or else its name."""
        node = self.own_node()
        if node is None:
            return ""
        last = self.last_messages.get(node.name)
        return f"; {node.name} last sent {text_of(last, repr)}" if last is not None else f"; in {node.name}"

    def _run_ready(self) -> None:
        while self._ready:
            node = self._next_ready()
            self._resumes += 1
            if self._resumes > self._max_resumes:
                problem = f"at {self.now_s:.3f} s: nodes wake each other without time passing"
                raise NodeError(node.name, self.now_s, problem)
            self._resume(node)

    def _next_ready(self) -> Node:
        number = self.choose(len(self._ready))
        if number == 0:
            return self._ready.popleft()
        node = self._ready[number]
        del self._ready[number]
        return node

    def choose(self, count: int) -> int:
        """Choose which of this many that are ready at one instant goes first, from 0."""
        return 0 if self.pick is None or count < 2 else self.pick(count)

    def _resume(self, node: Node) -> None:
        if node.ended:
            return
        try:
            # A greenlet that raises GreenletExit does not raise it here: it ends with it as its value.
            raised = self._enter(node)
        except NodeError:
            raise
        except TerminalInterrupt:
            raised = None  # as a process ends
        except BaseException as error:
            if not (isinstance(error, (Exception, SystemExit)) or word_of(error)):
                raise
            raised = error
        node.ended = node.greenlet.dead
        if isinstance(raised, BaseException):
            problem = f"failed at {self.now_s:.3f} s: {error_text(raised)}"
            raise NodeError(node.name, self.now_s, problem) from raised
        if node.ended and (problem := what_never_began(raised)):
            raise NodeError(node.name, self.now_s, f"did nothing: {problem}")

    def _enter(self, node: Node, raising: type[BaseException] | None = None) -> object:
        """Hand control over to a node until it blocks or ends; returns what its greenlet does."""
        outside, self.inside = self.inside, node
        try:
            return node.greenlet.switch() if raising is None else node.greenlet.throw(raising)
        finally:
            self.inside = outside
            self.returns += 1
            if self.notice_return is not None:
                self.notice_return(node)

    def _advance(self, target_us: int) -> None:
        if target_us > self.now_us:
            self._resumes = self._polls = self._reads = 0
        if self.world is None:
            self.now_us = max(self.now_us, target_us)
            return
        while self.now_us < target_us and not self._ready and self._stop is None:
            self.now_us = advance_world(self.world, self.now_us, target_us)
            if problem := what_never_began(self.world.observe()):  # type: ignore[func-returns-value]
                raise KernelError(problem)
            for notice in self.after_steps:
                notice()

    def _make_runnable(self, node: Node) -> None:
        """Once only: a node that is resumed twice would continue from its next wait at once."""
        if node.blocked:
            node.blocked = False
            node.wait += 1
            self._ready.append(node)
