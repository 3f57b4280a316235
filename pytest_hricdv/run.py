"""`Run`: one run of one concrete test, which `execution.case` makes and gives to the testbench's function `run`."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Protocol

from pytest_hricdv._base.message import InputError, nearest
from pytest_hricdv.declarations.bystander import Bystander
from pytest_hricdv.declarations.ros2 import MissingExecutableError
from pytest_hricdv.disturbance import Disturbance, Disturbances, MessageDisturbance
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest
from pytest_hricdv.generate.schedule import ScheduleDecision
from pytest_hricdv.lanes import ActorTimes, Lanes, order_bins, without_schedule
from pytest_hricdv.monitor import MonitorError, MonitorSet
from pytest_hricdv.run_course import Ending, RunCourse
from pytest_hricdv.runtime import Bus, Kernel, NodeError, Recorder
from pytest_hricdv.runtime.blocking_calls import HAS_TERMINALS
from pytest_hricdv.runtime.node_error import what_never_began

if TYPE_CHECKING:
    from pytest_hricdv.declarations.ros2 import Launch, Middleware, Ros2System, RosNode
    from pytest_hricdv.runtime.virtual.terminal import Terminal

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too

__all__ = ["Actions", "ConcreteAction", "ConcreteTest", "Ending", "Run", "ScheduleDecision"]


class TestbenchError(InputError):
    """The testbench is missing, or lacks a part; the message says which and what it is for."""

    __test__ = False


class UnstartableError(TestbenchError):
    """The testbench's `run` can start in no test of the session, since something that it needs is missing."""


class Actions(Protocol):
    """Produces the actions of a run, each when the node of the person asks for it; called in this node."""

    def __call__(self, run: Run, actor: str, /) -> Iterator[ConcreteAction]:
        """The actions of an actor; of the only one, an empty name."""


@dataclass
class Run:
    """The argument of the testbench's `run`: virtual time, bus, record, and the test to enact."""

    test: ConcreteTest
    kernel: Kernel
    bus: Bus
    recorder: Recorder
    measured: Callable[[Callable[[], None]], Callable[[], None]]
    """Wraps the body of the node that is the code under test: coverage is measured in this node's greenlet only."""
    monitors: MonitorSet = field(repr=False)
    filming: Callable[[Run], AbstractContextManager[None]] | None = None
    """Entered around the run when it is filmed; None otherwise."""
    producing: Actions | None = field(default=None, repr=False)
    """Produces the actions during the run; None: they are those of the test."""
    taken: list[ConcreteAction] = field(default_factory=list)
    """The actions that have begun, as far as `actions` or `report_action` reported it, in this order."""
    action_times_s: list[float] = field(default_factory=list)
    """When each of them began (s of simulated time)."""
    begun: list[int] = field(default_factory=list)
    """The number of each of them in the test, from 0."""
    actors: tuple[str, ...] = ()
    """The actors of the model."""
    bystanders: Mapping[str, Bystander] = field(default_factory=dict)
    """The actors without a model, by name."""
    bystander_events: list[tuple[float, str]] = field(default_factory=list)
    """The acts that bystanders began, and when (s of simulated time): `(4.0, "dog: walk")`."""
    fidelity: str = ""
    """How to simulate the world, as `--hri-fidelity` says; empty if it says nothing."""
    engine: str = ""
    """The physics engine to use, of the testbench's `engines`; empty if it has none."""
    ending: Ending | None = None
    """How `go` ended; None before."""
    may_go_round: bool = True
    """Whether it may repeat the same for as long as it likes; otherwise it is ended (see `runtime.livelock`)."""
    disturbances: Disturbances = field(default_factory=dict)
    """The disturbances of the testbench."""
    middleware: Middleware | None = field(default=None, repr=False)
    """The middleware with which `ros2` starts nodes, if the testbench declares a ROS 2 system."""
    before_end: Callable[[], None] | None = field(default=None, init=False, repr=False)
    """Called once the run is over, while its nodes are still where they wait."""
    waiting: Callable[[], None] | None = field(default=None, init=False, repr=False)
    """How the person waits, if `set_idle_handler` was called."""
    _disturbed: Any = field(default=None, init=False, repr=False)
    _lanes: Lanes | None = field(default=None, init=False, repr=False)
    _deciding: set[str] = field(default_factory=set, init=False, repr=False)
    """The actors who decide during the run and whose actions a node takes."""
    _times: ActorTimes = field(default_factory=ActorTimes, init=False, repr=False)
    _watched: set[str] = field(default_factory=set, init=False, repr=False)
    """The bystanders whose acts a node takes."""

    def set_disturbance_target(self, world: Any) -> None:
        """Hand over what the handlers of disturbances are called with; to be called before `go`."""
        self._disturbed = world

    def ros2(self, *nodes: RosNode | Launch) -> Ros2System:
        """Start nodes of ROS 2, or what launch files name, as the code under test; to be called before `go`.

        Each is as if in a process of its own.

        Returns:
            The system, for the world's side of it: `system.node("lidar").publisher("/scan", ...)`.

        Raises:
            TestbenchError: the testbench has no `ros2=Ros2(...)`, or a node cannot be started.
        """
        if self.middleware is None:
            raise TestbenchError("run.ros2: the testbench declares no ROS 2 system; give it ros2=Ros2(...)")
        try:
            return self.middleware.start(self.kernel, self.bus, self.measured, nodes, self.test.seed)
        except MissingExecutableError as error:
            raise UnstartableError(f"run.ros2: {error}") from None
        except InputError as error:
            raise TestbenchError(f"run.ros2: {error}") from None

    def terminal(self, name: str = "") -> Terminal:
        """The terminal of a process of the code under test; to be called before `go`, keys are pressed in nodes.

        What is typed is what its nodes read from standard input, with `termios`, `tty` and `select`. It is in the
        record, as `terminal_input` with `terminal` and `text`.

        Args:
            name: the name of a ROS node, as `RosNode` names its process, or of a node of the kernel; empty: of all that
                have no other one.

        Returns:
            The keyboard: `press("w", "enter")`, `type("yes\\n")`, `close()`.

        Raises:
            TestbenchError: on Windows, which has no such terminals.
        """
        if not HAS_TERMINALS:
            raise TestbenchError(
                "run.terminal: this system has no terminals of POSIX, which it simulates; use Linux or macOS"
            )
        from pytest_hricdv.runtime.virtual.terminal import terminal_for

        def record(text: str) -> None:
            self.recorder.message(self.kernel.now_s, "person", "terminal_input", {"terminal": name, "text": text})

        return terminal_for(self.kernel, name, record)

    def set_idle_handler(self, wait: Callable[[], None]) -> None:
        """Say how the person waits while there is nothing to do yet; to be called before `go`.

        Args:
            wait: called in the person's node by what produces the actions. It returns when something has happened, or
                nothing more is to be expected. What a command waits for before it begins may be waited for in here
                already: the run is the same without this waiting, as when its test is run again.

        Raises:
            TestbenchError: the model has several actors: each waits by itself until its agent has something to do.
        """
        if len(self.actors) > 1:
            raise TestbenchError(
                f"run.set_idle_handler: the model has the actors {', '.join(self.actors)}, each of which waits by "
                "itself until its agent has something to do; leave it out"
            )
        self.waiting = wait

    def actions(self, actor: str = "") -> Iterator[ConcreteAction]:
        """The actions of an actor, one after the other; taking the next one reports that it begins now.

        They are those of the test, or are produced during the run: take each when the person is free for it.
        Disturbances are applied when their turn comes, and are not among the actions: nobody enacts them.

        Where the model has several actors, each has a node of its own that takes its actions, without who does them
        and their turns. Taking the next one waits in virtual time until what caused it is done, and then, up to
        `turn_wait_s`, until it is its turn.

        Args:
            actor: the actor; may be left out if the model has one actor. Of a bystander, taking the next one
                waits for the pause before it.

        Raises:
            TestbenchError: there is no such actor, or several and none is named; or its actions are taken already.
        """
        if actor in self.bystanders:
            return self._acts_of_bystander(actor)
        self._check_actor(actor)
        if len(self.actors) > 1 and self.producing is not None:
            self._take_once(actor, self._deciding)
            return self._times.note_times(actor, self._actions_of_people(actor, self.producing), self.kernel)
        if len(self.actors) > 1:
            self._lanes = self._lanes or Lanes(self.test, self.kernel, self._begin)
            self._take_once(actor, {*self._lanes.taken})
            return self._times.note_times(actor, self._lanes.actions(actor), self.kernel)
        return self._all_actions()

    def _all_actions(self) -> Iterator[ConcreteAction]:
        for number, action in enumerate(self.test.actions if self.producing is None else self.producing(self, "")):
            self._begin(number, action)
            if self._disturbance_of(action) is None:
                yield action

    def _actions_of_people(self, actor: str, producing: Actions) -> Generator[ConcreteAction]:
        for action in producing(self, actor):
            self._begin(len(self.taken), action)
            if self._disturbance_of(action) is None:
                yield without_schedule(action)

    def _acts_of_bystander(self, name: str) -> Iterator[ConcreteAction]:
        self._take_once(name, self._watched)
        acts = self.bystanders[name].acts_of(self.test.run)

        def take() -> Iterator[ConcreteAction]:
            for pause_s, act, parameters in acts:
                self.kernel.sleep(pause_s)
                self.bystander_events.append((self.kernel.now_s, f"{name}: {act}"))
                yield ConcreteAction(act, parameters)

        return take()

    def _take_once(self, actor: str, taken: set[str]) -> None:
        if actor in taken:
            raise TestbenchError(f"run.actions({actor!r}): a node takes its actions already; expected one node")
        taken.add(actor)

    def _check_actor(self, actor: str) -> None:
        if actor in self.actors or not (actor or len(self.actors) > 1):
            return
        call, names = f"run.actions({actor!r})" if actor else "run.actions()", (*self.actors, *self.bystanders)
        whom = "an actor of the model, or of a bystander" if self.bystanders else "an actor of the model"
        raise TestbenchError(f"{call}: expected the name of {whom}{nearest(actor, names)}")

    def report_action(self, number: int) -> None:
        """Report that action `number` (from 0) of the test begins now, for a world that has the whole test.

        Explanations of failures show these times. An action that is a disturbance of the testbench is applied in here:
        whoever enacts the test skips it. With one actor they begin in order.

        Raises:
            TestbenchError: a disturbance that has a handler begins, and `set_disturbance_target` was not called.
        """
        if 0 <= number < len(self.test.actions):
            self._begin(number, self.test.actions[number])

    def _begin(self, number: int, action: ConcreteAction) -> None:
        is_next = number == len(self.taken) if len(self.actors) < 2 else number not in self.begun
        if is_next:
            self.taken.append(action)
            self.action_times_s.append(self.kernel.now_s)
            self.begun.append(number)
            disturbance = self._disturbance_of(action)
            if disturbance is not None:
                self._disturb(disturbance, action)

    def order_bins(self, one: str, other: str) -> tuple[tuple[str, str, str], ...]:
        """The actions of two actors that met, and which began first, as bins of a cross product (see `Outcome.cross`).

        Two meet if no other action of theirs began between them; what they did is without who did it.

        >>> run.order_bins("nurse", "child")                          # doctest: +SKIP
        (('send_on', 'step_in', 'child'), ('send_on', 'wait', 'nurse'))
        """
        return order_bins(self.taken, one, other)

    def overlap_bins(self, waiting: str, other: str) -> tuple[tuple[str, str], ...]:
        """What one actor waited to do, and what another one did meanwhile, as bins of a cross product.

        An actor waits from when it asks for its next action to when this begins: for what caused it, for its turn, or,
        where people decide during the run, for something to do.

        >>> run.overlap_bins("child", "nurse")                       # doctest: +SKIP
        (('step_out', 'rest'), ('step_out', 'call_out'))
        """
        return self._times.overlap_bins(waiting, other)

    def idle_actors(self) -> tuple[str, ...]:
        """Actors, bystanders among them, whose actions nobody has asked for: no node takes them."""
        unseen = tuple(name for name in self.bystanders if name not in self._watched)
        if self._lanes is not None:
            return self._lanes.idle + unseen
        if len(self.actors) > 1 and self.producing is not None:
            return tuple(name for name in self.actors if name not in self._deciding) + unseen
        return (() if self.begun or len(self.actors) < 2 else self.test.actors) + unseen

    def _disturbance_of(self, action: ConcreteAction) -> Disturbance | MessageDisturbance | None:
        """The testbench's disturbance of that name; None for what a person does."""
        name = action.disturbance
        return None if name is None else self.disturbances.get(name)

    def _disturb(self, disturbance: Disturbance | MessageDisturbance, action: ConcreteAction) -> None:
        self.recorder.disturbance(self.kernel.now_s, "test", action.command, action.parameters)
        if isinstance(disturbance, MessageDisturbance):
            self.bus.disturb(disturbance.topic, disturbance.message_fault(action.parameters))
            return
        if self._disturbed is None:
            raise TestbenchError(
                f"'{action.command}' at {self.kernel.now_s:.3f} s: no world to disturb; the testbench's run has to "
                "call run.set_disturbance_target(world) before run.go, with what the handler is to get"
            )
        assert disturbance.handler is not None, "checked with the testbench"
        if problem := what_never_began(disturbance.handler(self._disturbed, action.parameters)):
            raise TestbenchError(problem)

    @property
    def enacted(self) -> ConcreteTest:
        """The test that this is a run of: the one given, or, where its actions were produced, one with those taken.

        Of a given test it has all actions, also those that had not begun when the run was over.
        """
        taken = tuple(self.taken)
        if len(self.actors) > 1 and self.producing is None:
            return self.test
        return self.test if self.test.actions[: len(taken)] == taken else replace(self.test, actions=taken)

    def go(self, limit_s: float) -> str:
        """Run the nodes up to `limit_s`, then on to the last deadline that is open then; then end all nodes.

        What is triggered after `limit_s` may be undecided at the end: *pending*.

        Returns:
            Why it ended: what was given to `kernel.stop`, "idle", "limit", or which node failed. A failed node is a
            fault of the run, which has verdicts up to then; `ending` keeps it.

        Raises:
            TestbenchError: the run is over.
        """
        if self.ending is not None:
            ended = f"the run ended at {self.ending.time_s:g} s"
            raise TestbenchError(f"run.go called again, after {ended}: expected one call")
        course = RunCourse(
            self.kernel, self.monitors, self.recorder, lambda: len(self.taken), self.bus.senders, self.may_go_round
        )
        why = ""
        with nullcontext() if self.filming is None else self.filming(self):
            try:
                why, self.ending = course.run(limit_s)
                course.finish(why)  # people see that it has ended
            except NodeError as error:
                if isinstance(error.__cause__, MonitorError | TestbenchError):
                    raise  # by the requirements or the testbench, in whichever node it was noticed
                why, self.ending = f"{error.node} failed", Ending("failed", error.time_s, error)
            finally:
                # Before the nodes end, since it inspects their waits.
                if self.middleware is not None:
                    self.middleware.notice_stuck_nodes(self.kernel, is_idle=why == "idle")
                if self.before_end is not None:
                    self.before_end()
                self.kernel.close()
        return why
