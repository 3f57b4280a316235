"""The handover machine on the real kernel and bus, with an arm, a hand, a person and sensors that do as a test says."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from controller import machine
from controller.ports import (
    MESSAGES,
    HumanReady,
    JointPose,
    LegReady,
    Path,
    PlanningError,
    Reading,
    Request,
    TableDone,
    TurnDone,
)
from controller.robot import Robot
from controller.settings import Settings
from controller.waypoints import HOME
from pytest_hricdv.runtime import Bus, Kernel, Recorder

READY = Reading(gaze=True, pressure=True, location=True)
MOVE_S = 5.0
CLOSE_S = 1.2
OPEN_S = 0.5
SAY_S = 1.0


@dataclass(frozen=True)
class Strategy:
    """A planned way to `goal`."""

    goal: JointPose
    duration_s: float


@dataclass
class ScriptedArm:
    """Gets everywhere, but for the goals that it has no plan to, or on the way to which it is held up."""

    kernel: Kernel
    no_plan: set[JointPose] = field(default_factory=set)
    held_up: set[JointPose] = field(default_factory=set)
    speeds: list[float] = field(default_factory=list)
    at: JointPose = HOME
    arrives: Callable[[JointPose], None] = lambda goal: None

    def plan(self, waypoints: Sequence[JointPose], max_speed_rad_s: float) -> Strategy:
        """See `controller.ports.Arm`."""
        self.speeds.append(max_speed_rad_s)
        if waypoints[-1] in self.no_plan:
            raise PlanningError("a shelf is in the way")
        return Strategy(waypoints[-1], 0.0 if waypoints[-1] == self.at else MOVE_S)

    def follow(self, path: Path) -> bool:
        """See `controller.ports.Arm`."""
        assert isinstance(path, Strategy)
        self.kernel.sleep(path.duration_s)
        if path.goal in self.held_up:
            return False
        self.at = path.goal
        self.arrives(path.goal)
        return True


@dataclass
class ScriptedHand:
    """Closes and opens as scripted (`catches`, `opens`: one entry an attempt), and well when the script is over."""

    kernel: Kernel
    catches: list[bool] = field(default_factory=list)
    opens: list[bool] = field(default_factory=list)
    held: bool = False
    opened_at_s: list[float] = field(default_factory=list)
    closed_at_s: list[float] = field(default_factory=list)

    def close(self) -> bool:
        """See `controller.ports.Hand`."""
        self.closed_at_s.append(self.kernel.now_s)
        self.kernel.sleep(CLOSE_S)
        self.held = self.catches.pop(0) if self.catches else True
        return self.held

    def open(self) -> bool:
        """See `controller.ports.Hand`."""
        self.opened_at_s.append(self.kernel.now_s)
        self.kernel.sleep(OPEN_S)
        done = self.opens.pop(0) if self.opens else True
        self.held = self.held and not done
        return done

    def holds(self) -> bool:
        """See `controller.ports.Hand`."""
        return self.held


@dataclass(frozen=True)
class BenchClock:
    """The kernel's time."""

    kernel: Kernel

    def now_s(self) -> float:
        """See `controller.ports.Clock`."""
        return self.kernel.now_s

    def sleep(self, duration_s: float) -> None:
        """See `controller.ports.Clock`."""
        self.kernel.sleep(duration_s)


class Bench:
    """One robot and what it meets.

    Args:
        settings: of the robot.
        asks: how many legs the person asks for, one after the other.
        answers: the turns (from 1) in which the person says "ready"; all when None.
        readings: what the sensors say in each turn, None for silence; ready when the list is over.
        pause_s: how long the person waits before each request.
    """

    def __init__(
        self,
        settings: Settings | None = None,
        *,
        asks: int = 4,
        answers: Sequence[int] | None = None,
        readings: Sequence[Reading | None] = (),
        pause_s: float = SAY_S,
    ) -> None:
        self.kernel = Kernel()
        self.recorder = Recorder()
        self.bus = Bus(self.kernel, MESSAGES, self.recorder)
        self.arm = ScriptedArm(self.kernel)
        self.hand = ScriptedHand(self.kernel)
        self.robot = Robot(self.bus.port("robot"), BenchClock(self.kernel), self.arm, self.hand, settings or Settings())
        self._asks = asks
        self._answers = range(1, asks + 1) if answers is None else answers
        self._readings = list(readings)
        self._pause_s = pause_s

    def run(self, limit_s: float = 1000.0) -> str:
        """Run the whole machine; why it ended."""

        def control() -> None:
            machine.run(self.robot)
            self.kernel.stop("table done")

        self.kernel.spawn("robot", control)
        self.kernel.spawn("person", self._ask)
        self.kernel.spawn("voice", self._answer)
        self.kernel.spawn("sensors", self._sense)
        try:
            return self.kernel.run(limit_s)
        finally:
            self.kernel.close()

    def enter(self, state: str) -> str:
        """Run one state alone; its outcome."""
        outcomes: list[str] = []
        self.kernel.spawn("robot", lambda: outcomes.append(machine.STATES[state](self.robot)))
        self.kernel.run(self.kernel.now_s + 1000.0)
        return outcomes[0]

    def say(self, at_s: float, message: object) -> None:
        """Let a message come at a time."""
        self.later(at_s, lambda: self.bus.publish("somebody", message))

    def later(self, at_s: float, act: Callable[[], None]) -> None:
        """Let something happen at a time."""

        def wait_and_act() -> None:
            self.kernel.sleep(at_s)
            act()

        self.kernel.spawn(f"at {at_s} s", wait_and_act)

    @property
    def states(self) -> list[str]:
        """The states that were reported, in order."""
        return [str(message.fields["name"]) for message in self.recorder.messages if message.topic == "state"]

    @property
    def outcomes(self) -> list[str]:
        """How each turn ended, as said by the robot."""
        return [str(message.fields["outcome"]) for message in self.recorder.messages if message.topic == "turn_done"]

    @property
    def reasons(self) -> list[str]:
        """Why each turn ended so, as written in the journal."""
        return [turn.reason for turn in self.robot.journal.turns]

    @property
    def report(self) -> TableDone | None:
        """The report on the table; None when there was none."""
        reports = [message.fields for message in self.recorder.messages if message.topic == "table_done"]
        if not reports:
            return None
        (fields,) = reports
        return TableDone(int(fields["released"]), float(fields["duration_s"]), bool(fields["on_time"]))

    def entered_s(self, state: str) -> list[float]:
        """When a state was entered."""
        found = self.recorder.messages
        return [each.time_s for each in found if each.topic == "state" and each.fields["name"] == state]

    def _ask(self) -> None:
        ends = self.bus.subscribe(TurnDone)
        for _ in range(self._asks):
            self.kernel.sleep(self._pause_s)
            self.bus.publish("person", Request())
            ends.wait(1000.0)

    def _answer(self) -> None:
        offers = self.bus.subscribe(LegReady)
        while (leg := offers.wait(1000.0)) is not None:
            if leg.turn in self._answers:
                self.kernel.sleep(SAY_S)
                self.bus.publish("person", HumanReady())

    def _sense(self) -> None:
        while True:
            self.bus.wait_for_subscriber(Reading)
            reading = self._readings.pop(0) if self._readings else READY
            if reading is not None:
                self.bus.publish("sensors", reading)
            self.kernel.sleep(self.robot.settings.sensing_timeout_s + 1.0 if reading is None else SAY_S)
