"""The supply of legs (one waits at the pickup place until it is taken), and the pressure sensor of the robot's hand."""

from __future__ import annotations

import math
from collections.abc import Callable

from sim.engine import UPRIGHT, Engine, PhysicsTime, Vector
from sim.layout import BIN_M, LEG_LENGTH_M, PICKUP_M, assembly_place
from sim.leg import STILL_M_S, Held, Leg, RigidLeg

RESUPPLY_S = 3.0
"""From the release of a leg until the next one waits: shorter than the arm's way back."""

CLEAR_M = 0.20
"""A leg closer than this to the pickup place is removed before the next one is placed there."""

PRESSURE_N = 3.0
"""A larger change means that a person pulls: half of the lightest pull (6 N)."""


class LegSupply:
    """All legs of a run. `current` is the one at the pickup place or in the robot's hand."""

    def __init__(self, engine: Engine, time: PhysicsTime, make_leg: Callable[[Engine, Vector], Leg] = RigidLeg) -> None:
        self._engine = engine
        self._time = time
        self._make_leg = make_leg
        self.current = make_leg(engine, PICKUP_M)
        self.legs = [self.current]
        self.received = 0  # legs that the person set down
        self.due_step: int | None = None
        self._carried: list[Leg] = []

    @property
    def in_hand(self) -> Leg | None:
        """The leg that the robot holds."""
        return self.current if self.current.held is Held.ROBOT else None

    @property
    def carried(self) -> Leg | None:
        """The leg that the person carries."""
        return self._carried[0] if self._carried else None

    def release(self, hand: int | None) -> None:
        """The robot's hand has opened: the person's `hand` (a body) takes the leg, or the leg falls if that is None."""
        if hand is None:
            self.current.drop()
        else:
            self.current.take(hand)
            self._carried.append(self.current)
        self.due_step = self._time.step_in(RESUPPLY_S)

    def set_down(self) -> None:
        """The person puts the carried leg down at its assembly place."""
        leg = self.carried
        if leg is not None:
            self._engine.place(leg.body, (assembly_place(self.received), UPRIGHT))
            leg.finish()
            self._carried.remove(leg)
            self.received += 1

    def tick(self) -> None:
        """At every control tick: place a new leg at the pickup place when it is due."""
        if self.due_step is None or self._time.step < self.due_step:
            return
        self.due_step = None
        for leg in self.legs:
            if leg.held is Held.LOOSE:
                leg.finish()
            if leg.held is Held.DONE and math.dist(leg.pose()[0], PICKUP_M) < CLEAR_M:
                self._engine.place(leg.body, ((BIN_M[0], BIN_M[1], BIN_M[2] + LEG_LENGTH_M / 2), UPRIGHT))
        self.current = self._make_leg(self._engine, PICKUP_M)
        self.legs.append(self.current)

    def still(self) -> bool:
        """True when no leg moves (faster than STILL_M_S) and none is carried."""
        if self.carried is not None:
            return False
        return all(leg.speed() <= STILL_M_S for leg in self.legs if leg.held is not Held.DONE)

    def poses(self) -> tuple[tuple[float, ...], ...]:
        """Position and orientation of every leg: for comparing and filming runs."""
        return tuple((*position, *turn) for position, turn in (leg.pose() for leg in self.legs))


class PressureSensor:
    """Change of the held leg's force on the palm, tared when arm or hand have come to rest with a leg."""

    def __init__(self, legs: LegSupply) -> None:
        self._legs = legs
        self._rest: Vector = (0.0, 0.0, 0.0)

    def tare(self) -> None:
        """Take the present force as the rest value; without effect when no leg is held."""
        leg = self._legs.in_hand
        if leg is not None:
            self._rest = leg.reaction()

    def change_n(self) -> float:
        """Difference (N) of the reaction from its rest value; 0 when no leg is held."""
        leg = self._legs.in_hand
        return 0.0 if leg is None else math.dist(leg.reaction(), self._rest)
