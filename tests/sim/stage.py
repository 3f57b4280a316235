"""A world with its nodes and a small robot program, for tests."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from types import TracebackType
from typing import Self

from controller import waypoints
from controller.ports import MESSAGES, HumanReady, LegReady, Reading, Request, TurnDone
from pytest_hricdv.runtime import Bus, Kernel, Record, Recorder
from sim.human import Human
from sim.robot import Robot
from sim.sensors import Sensors
from sim.world import World

Step = tuple[str, Mapping[str, float]]

OWN_SIDE = {"rest_x_m": 0.78, "rest_y_m": 0.10, "rest_z_m": 0.46}
AT_LEG = {"dx_m": 0.03, "dy_m": 0.0, "dz_m": -0.03}
OFF_LEG = {"dx_m": 0.6, "dy_m": 0.55, "dz_m": 0.55}
LOOKING = {"offset_m": 0.15, "distance_m": 0.55, "angle_deg": 20.0, "side": 1.0}


def one_leg(
    *,
    rest: Mapping[str, float] = OWN_SIDE,
    at_leg: bool = True,
    pull_n: float = 8.0,
    grip_s: float = 0.0,
) -> list[Step]:
    """The commands of a person who asks for a leg and takes it, or does not reach for it."""
    location = ("set_param location = 1", AT_LEG) if at_leg else ("set_param location = 0", OFF_LEG)
    return [
        ("tell leg", {"voice_s": 3.0, **rest}),
        ("receivesignal", {}),
        location,
        ("set_param pressure = 1", {"pull_n": pull_n, "grip_s": grip_s}),
        ("set_param gaze = 1", LOOKING),
        ("tell humanReady", {"voice_s": 2.0}),
    ]


class Stage:
    """Kernel, bus, record, world and robot ports of one run."""

    def __init__(self, *, freeze: bool = True) -> None:
        self.kernel = Kernel()
        self.recorder = Recorder()
        self.bus = Bus(self.kernel, MESSAGES, self.recorder)
        self.world = World(self.recorder, freeze=freeze)
        self.kernel.world = self.world
        self.robot = Robot(self.kernel, self.world)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.kernel.close()
        self.world.close()

    def run(self, body: Callable[[], None], limit_s: float = 300.0) -> str:
        """Run `body` as the robot's node until it is over."""

        def to_the_end() -> None:
            body()
            self.kernel.stop("over")

        self.kernel.spawn("robot", to_the_end)
        return self.kernel.run(self.kernel.now_s + limit_s)

    def human(self, script: Iterable[Step], patience_s: float = 60.0) -> Human:
        """Let a person enact a script."""
        human = Human(self.world, self.bus.port("human"), self.kernel, script, patience_s)
        self.kernel.spawn("human", human.enact)
        return human

    def sensors(self, seed: int = 0, error_probability: float = 0.0, outage_turn: int = 0) -> Sensors:
        """Let sensors publish."""
        sensors = Sensors(self.world, self.bus.port("sensors"), self.kernel, seed, error_probability, outage_turn)
        self.kernel.spawn("sensors", sensors.sense)
        return sensors

    def fetch(self, max_speed_rad_s: float = 0.25) -> bool:
        """Bring a leg to the handover place; True when it is held there."""
        arm, hand = self.robot.arm, self.robot.hand
        arrived = arm.follow(arm.plan(waypoints.TO_PICKUP, max_speed_rad_s))
        held = hand.close()
        return arm.follow(arm.plan(waypoints.TO_HANDOVER, max_speed_rad_s)) and arrived and held

    def discard(self) -> bool:
        """Open over the re-supply bin; True when the hand is seen open."""
        arm = self.robot.arm
        return arm.follow(arm.plan(waypoints.TO_RESUPPLY, 0.25)) and self.robot.hand.open()

    def serve(self, turns: int) -> None:
        """The whole handover, in short: a robot program that releases on a ready reading and discards on any other."""
        port = self.bus.port("robot")
        requests, ready = port.subscribe(Request), port.subscribe(HumanReady)
        for turn in range(1, turns + 1):
            if requests.wait(100.0) is None:
                return
            self.fetch()
            ready.clear()
            port.publish(LegReady(turn))
            reading = self._sense() if ready.wait(15.0) is not None else None
            if reading is not None and reading.gaze and reading.pressure and reading.location:
                while not self.robot.hand.open():
                    self.kernel.sleep(1.0)
                port.publish(TurnDone(turn, "released"))
            else:
                self.discard()
                port.publish(TurnDone(turn, "discarded"))
        self.kernel.sleep(8.0)

    def _sense(self) -> Reading | None:
        readings = self.bus.port("robot").subscribe(Reading)
        try:
            return readings.wait(20.0)
        finally:
            readings.close()


def handover(script: Sequence[Step], turns: int, *, freeze: bool = True, seed: int = 1) -> tuple[Record, Stage]:
    """A whole run; its record, and its stage (closed)."""
    with Stage(freeze=freeze) as stage:
        stage.human(script)
        stage.sensors(seed, error_probability=0.05)
        stage.run(lambda: stage.serve(turns))
        return stage.recorder.finish(), stage
