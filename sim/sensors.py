"""The sensors: gaze, pressure and location, read from the physical world, classified, and disturbed by errors."""

from __future__ import annotations

import random
from dataclasses import dataclass

from controller.ports import LegReady, Reading, TurnDone
from pytest_hricdv.runtime import Kernel, NodeBus
from sim.engine import SimulationError
from sim.gaze import gaze_of
from sim.leg_supply import PRESSURE_N
from sim.sensor_faults import SensorFaults
from sim.world import World

PERIOD_S = 0.02
"""About 50 readings a second."""

OFFSET_M = 0.2
DISTANCE_M = 0.6
ANGLE_DEG = 40.0
LOCATION_M = 0.3
"""Limits of a person who is ready: gaze offset, distance and angle; hand to leg on every axis. Case study."""

RESOLUTION = 1e-6
"""Resolution of the trackers (m, degrees): a rounding error does not move a head beyond a limit."""

SILENT_S = 1000.0
"""Longer than any run: the testbench ends them at 900 s (conftest.py)."""


@dataclass(frozen=True)
class Truth:
    """The true values, before any sensor error."""

    gaze: bool
    pressure: bool
    location: bool


def classify(world: World) -> Truth:
    """Classify the present poses."""
    place = world.legs.place()
    gaze = gaze_of(world.person.head.pose(), place)
    hand = world.person.hand.pose()[0]
    return Truth(
        gaze=gaze.offset_m <= OFFSET_M + RESOLUTION
        and gaze.distance_m <= DISTANCE_M + RESOLUTION
        and gaze.angle_deg < ANGLE_DEG,
        pressure=world.pressure.change_n() > PRESSURE_N,
        location=all(abs(a - b) <= LOCATION_M + RESOLUTION for a, b in zip(hand, place, strict=True)),
    )


class Sensors:
    """Publishes `Reading` at 50 Hz while it has subscribers.

    Args:
        world: is sensed.
        bus: carries the readings.
        kernel: virtual time.
        seed: of the sensor errors.
        error_probability: for each reading: that gaze or location is missed (each), and that pressure is read though
            nobody pulls at the held leg. Case study: about 5 %.
        outage_turn: the turn (1 to 4) without readings; 0 for none.

    Raises:
        SimulationError: a probability outside [0, 1], or a negative turn.
    """

    def __init__(
        self,
        world: World,
        bus: NodeBus,
        kernel: Kernel,
        seed: int,
        error_probability: float = 0.05,
        outage_turn: int = 0,
    ) -> None:
        if not 0.0 <= error_probability <= 1.0:
            raise SimulationError(f"error probability {error_probability!r}: expected 0 to 1")
        if outage_turn < 0:
            raise SimulationError(f"outage in turn {outage_turn}: expected 0 for none, or a turn")
        self._world = world
        self._bus = bus
        self._kernel = kernel
        self._random = random.Random(seed)
        self._error_probability = error_probability
        self._outage_turn = outage_turn
        self._turns = bus.subscribe(LegReady)
        self._ends = bus.subscribe(TurnDone)
        self._turn = 0
        self.faults = SensorFaults()

    def sense(self) -> None:
        """The node's body: publish while there are subscribers, forever."""
        while True:
            self._bus.wait_for_subscriber(Reading)
            self._follow_turns()
            if self._in_outage():
                self._turn_ended(self._ends.wait(SILENT_S))
                continue
            silent_s = self.faults.silent_until_s - self._kernel.now_s
            if silent_s > 0.0:
                self._kernel.sleep(silent_s)
                continue
            reading = self.faults.applied(self.read(), self._kernel.now_s)
            if self._is_heard_after(self.faults.delay_s()):
                self._bus.publish(reading)
                self._kernel.sleep(PERIOD_S)

    def flip(self, sensor: str) -> None:
        """A sensor, named as a field of `Reading`, reads the opposite until the robot reports the end of a turn."""
        self._follow_turns()  # a turn that has ended before is another one
        self.faults.flipped.add(sensor)

    def read(self) -> Reading:
        """One reading with errors. Always draws three random numbers, so that one error never shifts another."""
        truth = classify(self._world)
        miss_gaze, feel, miss_location = (self._random.random() < self._error_probability for _ in range(3))
        held = self._world.legs.in_hand is not None
        return Reading(
            gaze=truth.gaze and not miss_gaze,
            pressure=truth.pressure or (held and feel),
            location=truth.location and not miss_location,
        )

    def _is_heard_after(self, delay_s: float) -> bool:
        if delay_s > 0.0:
            self._kernel.sleep(delay_s)
        return self._bus.has_subscribers(Reading)

    def _in_outage(self) -> bool:
        return self._outage_turn > 0 and self._turn == self._outage_turn

    def _follow_turns(self) -> None:
        while (ready := self._turns.poll()) is not None:
            self._turn = ready.turn
        while (end := self._ends.poll()) is not None:
            self._turn_ended(end)

    def _turn_ended(self, end: TurnDone | None) -> None:
        if end is None:
            return
        self.faults.flipped.clear()
        if end.turn == self._turn:
            self._turn = 0
