"""The environment of one test: world, person and sensors as nodes, the robot's ports, and the end of the run."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from types import TracebackType
from typing import Self

from controller.ports import State, TableDone
from pytest_hricdv.runtime import Bus, Kernel, Recorder, topic_of
from sim.engine import SimulationError
from sim.events import Event
from sim.human import Human
from sim.robot import Robot, wait_until
from sim.script import Step
from sim.sensors import Sensors
from sim.world import World

IDLE_STATE = "Timeout1"
"""The robot enters this state when no request came."""

WAIT_S = 1000.0
"""Longer than any run."""


class Workshop:
    """Everything that a controller interacts with in one run; a context manager.

    Args:
        kernel: keeps the time.
        bus: carries the messages.
        recorder: receives the world's signals.
        script: what the person enacts: commands with their parameters (see `sim.script`), each taken when it begins.
        seed: of the sensor errors.
        sensor_error: probability of an error per reading and sensor.
        outage_turn: the turn without readings; 0 for none.
        freeze: skip physics steps while nothing can move.
        fidelity: "dynamic" or "kinematic" (see `sim.mechanics`).
        engine: of physics (see `sim.engines`).
    """

    def __init__(
        self,
        kernel: Kernel,
        bus: Bus,
        recorder: Recorder,
        script: Iterable[Step],
        *,
        seed: int,
        sensor_error: float = 0.05,  # case study: about 5 % of readings each
        outage_turn: int = 0,
        freeze: bool = True,
        fidelity: str = "dynamic",
        engine: str = "",
    ) -> None:
        self._bus = bus
        self._recorder = recorder
        self.kernel = kernel
        self.world = World(recorder, freeze=freeze, fidelity=fidelity, engine=engine)
        try:
            kernel.world = self.world
            self.robot = Robot(kernel, self.world)
            self.human = Human(self.world, bus.port("human"), kernel, script)
            self.sensors = Sensors(self.world, bus.port("sensors"), kernel, seed, sensor_error, outage_turn)
        except BaseException:
            self.world.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.world.close()

    def start(self, control: Callable[[], None]) -> None:
        """Start all nodes; `control` is the controller's body. The run ends with it, or when no more requests can come.

        A controller that ends without having reported a table is an error of the robot's node.
        """

        def robot() -> None:
            control()
            if all(message.topic != topic_of(TableDone) for message in self._recorder.messages):
                said = self.kernel.last_messages.get("robot", "nothing")
                raise SimulationError(f"the controller ended without a table; it last said {said}")
            self.kernel.stop("table done")

        # The person first: what is so at the start, such as a leg in the hand, has to be before the robot looks.
        self.kernel.spawn("human", self.human.enact)
        self.kernel.spawn("robot", robot)
        self.kernel.spawn("sensors", self.sensors.sense)
        self.kernel.spawn("end of work", self._end)

    def tell(self, event: Event) -> None:
        """Record an event that the robot hears nothing of."""
        self._bus.publish("world", event)

    def later(self, delay_s: float, act: Callable[[], None]) -> None:
        """Do something after a time (s), whatever the person does until then."""

        def wait_and_act() -> None:
            self.kernel.sleep(delay_s)
            act()

        self.kernel.spawn("disturbance", wait_and_act)

    def when(self, condition: Callable[[], bool], act: Callable[[], None]) -> None:
        """Do something at the first control tick at which a condition of the world holds."""

        def wait_and_act() -> None:
            if wait_until(self.kernel, self.world, condition, WAIT_S):
                act()

        self.kernel.spawn("disturbance", wait_and_act)

    def _end(self) -> None:
        states = self._bus.subscribe(State)
        while True:
            state = states.wait(WAIT_S)
            if state is not None and state.name == IDLE_STATE and self.human.done:
                self.kernel.stop("nobody asks any more")
