"""The Chasing Cars of ARCH-COMP: our own implementation, from the equations of the published model.

The cars drive towards smaller numbers. The first has throttle and brake; each other one chases the car before it, by
its distance. A car that keeps its speed moves the other way: `y' = v`, while `y' = -v` chases and brakes. This is how
the model was published, and all published figures are of it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

DURATION_S = 100.0
STEP_S = 0.1
"""Between two samples. The motion between two transitions is exact, as all equations can be solved; a transition is
noticed if it is due at the end of a step or of a part of one, and its instant is solved for."""
PRECISE = 1e-9
"""Of distances at transitions (m)."""
APART = 10.0
"""Distance of the cars at the start, when all of them stand."""

Segment = tuple[float, float]
"""Throttle and brake, for an equal share of the run."""


class Pursuit(Enum):
    """What a car does that chases another."""

    CHASING = "chasing"
    KEEPING = "keeping"
    BRAKING = "braking"


@dataclass
class Leader:
    """The first car: v' = -throttle - brake * v, y' = v.

    Args:
        place: y.
        speed: v.
        throttle: constant for a step.
        brake: likewise.
    """

    place: float = 0.0
    speed: float = 0.0
    throttle: float = 0.0
    brake: float = 0.0

    def after(self, time_s: float) -> tuple[float, float]:
        """Place and speed after a time."""
        if self.brake * time_s < 1e-9:
            return self.place + self.speed * time_s - self.throttle * time_s**2 / 2, self.speed - self.throttle * time_s
        final = -self.throttle / self.brake
        share = -math.expm1(-self.brake * time_s)
        place = self.place + final * time_s + (self.speed - final) * share / self.brake
        return place, self.speed + (final - self.speed) * share


@dataclass
class Chaser:
    """A car that chases another.

    Args:
        place: y.
        speed: v.
        pursuit: what it does.
    """

    place: float
    speed: float = 0.0
    pursuit: Pursuit = Pursuit.KEEPING

    def after(self, time_s: float) -> tuple[float, float]:
        """Place and speed after a time: by v' = 1, y' = -v; v' = 0, y' = v; or v' = -v, y' = -v."""
        if self.pursuit is Pursuit.CHASING:
            return self.place - self.speed * time_s - time_s**2 / 2, self.speed + time_s
        if self.pursuit is Pursuit.KEEPING:
            return self.place + self.speed * time_s, self.speed
        share = -math.expm1(-time_s)
        return self.place - self.speed * share, self.speed - self.speed * share

    def due(self, distance: float) -> Pursuit | None:
        """What it goes over to at a distance to the car before it; None: it goes on."""
        if self.pursuit is Pursuit.CHASING:
            return Pursuit.KEEPING if distance <= 10.0 else None
        if self.pursuit is Pursuit.BRAKING:
            return Pursuit.CHASING if distance >= 20.0 else None
        if distance >= 15.0:
            return Pursuit.CHASING
        return Pursuit.BRAKING if distance <= 5.0 else None


BOUNDS = {
    (Pursuit.CHASING, Pursuit.KEEPING): 10.0,
    (Pursuit.KEEPING, Pursuit.CHASING): 15.0,
    (Pursuit.KEEPING, Pursuit.BRAKING): 5.0,
    (Pursuit.BRAKING, Pursuit.CHASING): 20.0,
}
"""Distances at which a chaser goes over from one to the other."""

Car = Leader | Chaser


@dataclass(frozen=True)
class Course:
    """A run.

    Args:
        times_s: of the samples.
        places: y1 to y5, each at these times.
    """

    times_s: Sequence[float]
    places: Sequence[Sequence[float]]


def drive(segments: Sequence[Segment], step_s: float = STEP_S) -> Course:
    """Simulate, with throttle and brake constant for an equal share of the run each."""
    leader = Leader()
    chasers = [Chaser(APART * number) for number in range(1, 5)]
    cars: tuple[Car, ...] = (leader, *chasers)
    steps = round(DURATION_S / step_s)
    times_s, places = [0.0], [[car.place] for car in cars]
    for step in range(steps):
        leader.throttle, leader.brake = segments[step * len(segments) // steps]
        _advance(cars, chasers, step_s)
        times_s.append((step + 1) * step_s)
        for values, car in zip(places, cars, strict=True):
            values.append(car.place)
    return Course(times_s, places)


def _advance(cars: Sequence[Car], chasers: Sequence[Chaser], time_s: float) -> None:
    """Move all cars, from transition to transition."""
    while True:
        ends = [car.after(time_s) for car in cars]
        first_s, number, following = time_s, 0, None
        for place, chaser in enumerate(chasers):
            then = chaser.due(ends[place + 1][0] - ends[place][0])
            if then is None:
                continue
            due_s = _reaches_s(cars[place], chaser, BOUNDS[chaser.pursuit, then], time_s)
            if following is None or due_s < first_s:
                first_s, number, following = due_s, place, then
        if following is not None:
            ends = [car.after(first_s) for car in cars]
        for car, end in zip(cars, ends, strict=True):
            car.place, car.speed = end
        if following is None:
            return
        chasers[number].pursuit = following
        time_s -= first_s


def _reaches_s(before: Car, chaser: Chaser, bound: float, end_s: float) -> float:
    """When its distance reaches a bound that it has passed at the end of a step: by false position (Illinois)."""
    begin_s = 0.0
    begin, end = (chaser.after(at_s)[0] - before.after(at_s)[0] - bound for at_s in (begin_s, end_s))
    if begin * end >= 0.0:
        return 0.0 if begin * end > 0.0 or begin == 0.0 else end_s
    while abs(end) > PRECISE:
        at_s = end_s - end * (end_s - begin_s) / (end - begin)
        here = chaser.after(at_s)[0] - before.after(at_s)[0] - bound
        if here * end < 0.0:
            begin_s, begin = end_s, end
        else:
            begin /= 2
        end_s, end = at_s, here
    return end_s
