"""The supply of legs (one waits at the pickup place until it is taken), and the pressure sensor of the robot's hand."""

from __future__ import annotations

import math
from collections.abc import Callable

from sim.engine import Engine, PhysicsTime, check_finite
from sim.geometry import UPRIGHT, Vector
from sim.layout import HANDOVER_M, PICKUP_M, STORE_M, assembly_place
from sim.leg import STILL_M_S, Held, Leg, RigidLeg

RESUPPLY_S = 3.0
"""From the release of a leg until the next one waits: shorter than the arm's way back. What fell rests by then."""

CLEAR_M = 0.20
"""A leg that fell closer than this to where the hand fetches legs, or holds them out, is put away before the next one
is placed: the hand, or the leg in it, would hit it. Chosen: from 0.1 to 0.4 the records are the same (see
`sim.world.REST_TICKS`)."""

PRESSURE_N = 3.0
"""A larger change means that a person pulls: half of the lightest pull (6 N). From 1 to 5 N the records are the same
(see `sim.world.REST_TICKS`)."""


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
        self._rests_step: int | None = None  # legs that were dropped do not move from then on
        self.missing = False  # the current leg is put away
        self._not_before_step = 0
        self._shift_m: tuple[float, float] = (0.0, 0.0)  # of the next leg from the pickup place, along x and y
        self._carried: list[Leg] = []

    @property
    def changes_step(self) -> int | None:
        """The next step at which a leg comes, or one that was dropped rests; None if there is none."""
        steps = [step for step in (self.due_step, self._rests_step) if step is not None]
        return min(steps, default=None)

    @property
    def in_hand(self) -> Leg | None:
        """The leg that the robot holds."""
        return self.current if self.current.held is Held.ROBOT else None

    @property
    def waiting(self) -> Leg | None:
        """The leg that waits at the pickup place."""
        return self.current if self.current.held is Held.PINNED and not self.missing else None

    @property
    def carried(self) -> Leg | None:
        """The leg that the person carries."""
        return self._carried[0] if self._carried else None

    def place(self) -> Vector:
        """Where people and sensors look for the current leg (m): where it is, or where it is missing."""
        return PICKUP_M if self.missing else self.current.pose()[0]

    def release(self, hand: int | None) -> None:
        """The leg leaves its place: the person's `hand` (a body) takes it, or it falls if that is None."""
        if hand is None:
            self.current.drop()
        else:
            self.current.take(hand)
            self._carried.append(self.current)
        self._rests_step = self._time.step_in(RESUPPLY_S)
        self.due_step = max(self._rests_step, self._not_before_step)

    def take(self, hand: int, next_s: float) -> None:
        """The person's `hand` (a body) takes the leg that waits, if one does; the next one comes after `next_s`."""
        check_finite("time without a leg", (next_s,))
        if self.waiting is not None:
            self.release(hand)
            self.due_step = max(self._time.step_in(next_s), self._not_before_step)

    def withhold(self, for_s: float) -> None:
        """No leg comes to the pickup place for this time (s); the one that waits there is put away."""
        check_finite("time without a leg", (for_s,))
        self._not_before_step = self._time.step_in(for_s)
        if self.waiting is not None:
            self.missing = True
            self._engine.place(self.current.body, (STORE_M, UPRIGHT))
        if self.due_step is not None or self.missing:
            self.due_step = max(self.due_step or 0, self._not_before_step)

    def displace(self, dx_m: float, dy_m: float) -> None:
        """The leg that waits stands beside the pickup place by this much (m); where none waits, the next one will."""
        check_finite("displacement of a leg", (dx_m, dy_m))
        self._shift_m = (dx_m, dy_m)
        if self.waiting is not None:
            self._engine.place(self.current.body, (self._pickup_place(), UPRIGHT))

    def set_down(self, leg: Leg) -> None:
        """The person puts a leg down at its assembly place; without effect if it is not carried any more."""
        if leg in self._carried:
            self._engine.place(leg.body, (assembly_place(self.received), UPRIGHT))
            leg.finish()
            self._carried.remove(leg)
            self.received += 1

    def tick(self) -> None:
        """At every control tick: place a new leg at the pickup place when it is due."""
        self._rest()
        if self.due_step is None or self._time.step < self.due_step:
            return
        self.due_step = None
        self._clear()
        if self.missing:
            self.missing = False
            self._engine.place(self.current.body, (self._pickup_place(), UPRIGHT))
        else:
            self.current = self._make_leg(self._engine, self._pickup_place())
            self.legs.append(self.current)

    def _clear(self) -> None:
        """Put away what fell where the next leg comes by; in the bin it would stand in the way of others."""
        for leg in self.legs:
            x, y, _ = leg.pose()[0]
            if leg.held is Held.DONE and any(math.dist((x, y), at[:2]) < CLEAR_M for at in (PICKUP_M, HANDOVER_M)):
                self._engine.place(leg.body, (STORE_M, UPRIGHT))

    def _rest(self) -> None:
        """Legs that were dropped stay where they are, once they have had the time to fall.

        One that rolled on until the next leg came, which may be minutes later, would leave the floor's edge and fall
        for ever; and a leg that physics moves costs time in each step.
        """
        if self._rests_step is None or self._time.step < self._rests_step:
            return
        self._rests_step = None
        for leg in self.legs:
            if leg.held is Held.LOOSE:
                leg.finish()

    def _pickup_place(self) -> Vector:
        (dx_m, dy_m), self._shift_m = self._shift_m, (0.0, 0.0)
        return (PICKUP_M[0] + dx_m, PICKUP_M[1] + dy_m, PICKUP_M[2])

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
