"""The robot's hand at work: fingers close around a leg and it is held; they open far enough and it is let go."""

from __future__ import annotations

import math
from collections.abc import Callable
from enum import Enum, auto

from sim.engine import Engine, bullet, finite
from sim.fingers import CLOSED, OPEN, Fingers
from sim.leg import Leg
from sim.leg_supply import LegSupply
from sim.person import Person
from sim.places import HANDOVER_M, LEG_LENGTH_M
from sim.torso import Torso
from sim.touch import Touch

CLOSE_S = 1.2
OPEN_S = 0.6
"""Time of a finger movement when nothing is in its way."""

STAND_RAD_S = 0.01
"""Fingers slower than this stand."""

COVERED_RAD = 0.01
"""Fingers this near to their goal have no way to go."""

RELEASE_RAD = -0.30
"""The four fingers' first joints must all have opened beyond this angle before a leg is free: half of CLOSED."""

SEEN_OPEN_RAD = 0.10
"""Fingers are seen to be open when every joint is this near to stretched."""

GRASP_POINT_M = (0.043, 0.10, 0.0)
"""Middle of the grasp, in the palm's frame: one leg radius off the palm, over the roots of the fingers."""

GRASP_REGION_M = 0.03
"""A leg whose axis passes this near to the grasp point is between the closing fingers."""

REACH_M = 0.08
"""The person's hand is at the leg when it is this near to it: then the released leg is taken."""

CLASP_M = 0.15
"""The person's hand can clasp the robot's fingers when it is this near to the palm."""

CLASP_N_RAD = (60.0, 20.0)
CLASP_MAX_N = 30.0
"""A clasping hand gives way like a one-sided spring of this stiffness (N at the tip of a finger's first and second
link, per rad that it has opened): it withstands the finger motors well before RELEASE_RAD (tests/sim/test_grasp.py)."""

FORCE_DIGITS = 3
"""Forces are recorded to a millinewton."""

Signal = Callable[[str, float | bool], None]


class Doing(Enum):
    """What the fingers are about."""

    NOTHING = auto()
    CLOSING = auto()
    OPENING = auto()


class Gripper:
    """Commands to the fingers, and what follows from where the fingers physically are."""

    def __init__(
        self, engine: Engine, torso: Torso, fingers: Fingers, legs: LegSupply, person: Person, signal: Signal
    ) -> None:
        self._engine = engine
        self._torso = torso
        self._fingers = fingers
        self._legs = legs
        self._person = person
        self._signal = signal
        self._touch = Touch(engine, torso, fingers, person.hand.body)
        self._distance_m = 0.0  # at the last step of closing
        self.doing = Doing.NOTHING

    def close(self) -> None:
        """Start to close the fingers."""
        self._fingers.follow(self._torso.palm_pose())
        self._fingers.move(CLOSED, CLOSE_S)
        self.doing = Doing.CLOSING
        if self._to_go(CLOSED) > COVERED_RAD:
            self._distance_m = self.human_distance()
            self._signal("hand_distance", self._distance_m)
            self._signal("hand_closing", True)

    def open(self) -> None:
        """Start to open the fingers."""
        self._end_closing()
        self._fingers.move(OPEN, OPEN_S)
        self.doing = Doing.OPENING

    @property
    def busy(self) -> bool:
        """True while `before_step` has something to do: the fingers move, or a leg is held that may be pulled at."""
        return self.doing is not Doing.NOTHING or self._legs.in_hand is not None

    def at_rest(self) -> bool:
        """True when the last command is done."""
        return self.doing is Doing.NOTHING

    def seen_open(self) -> bool:
        """True when all fingers are measured to be open."""
        return self._to_go(OPEN) < SEEN_OPEN_RAD

    def human_distance(self) -> float:
        """Smallest distance (m, to a micrometre) between the person's hand and the robot's palm and fingers."""
        return self._touch.distance()

    def before_step(self) -> None:
        """Forces of the person on fingers and leg for the next physics step."""
        if self.doing is Doing.CLOSING:
            self._meet_hand()
        leg = self._legs.in_hand
        if leg is not None:
            pull_n = self._person.pull_now()
            if pull_n:
                leg.pull((pull_n, 0.0, 0.0))
            if self.doing is Doing.OPENING and self._clasped():
                self._clasp()

    def after_step(self) -> None:
        """What this step's finger positions mean, while the fingers move."""
        self._fingers.follow(self._torso.palm_pose())
        if self.doing is Doing.CLOSING:
            self._distance_m = self.human_distance()
            self._signal("hand_distance", self._distance_m)
        elif self.doing is Doing.OPENING and self._legs.in_hand is not None and self._beyond_release():
            self._let_go(self._legs.in_hand)

    def tick(self) -> None:
        """Once every control tick: has the hand done what it was about?"""
        self._fingers.follow(self._torso.palm_pose())
        held = self._legs.in_hand
        if held is not None and self._person.pulls and held.torn():
            self._signal("leg_torn", True)
            self._let_go(held)
        if self.doing is Doing.CLOSING and self._stand_at(CLOSED):
            self._end_closing()
            self._stop()
            leg = self._legs.current
            if leg.graspable and self._in_grasp(leg):
                leg.grasp(self._torso)
                self._signal("leg_torn", False)
                self._signal("leg_held", True)
        elif self.doing is Doing.OPENING and self._stand_at(OPEN):
            self._stop()

    def _meet_hand(self) -> None:
        force_n = 0.0
        if self._distance_m < 0.0:
            self._touch.press()
            force_n = self._touch.force_n
        self._signal("hand_contact_force", round(force_n, FORCE_DIGITS))

    def _end_closing(self) -> None:
        self._signal("hand_closing", False)
        self._signal("hand_contact_force", 0.0)

    def _stop(self) -> None:
        self.doing = Doing.NOTHING
        self._fingers.rest()

    def _let_go(self, leg: Leg) -> None:
        at_leg = self._engine.distance(self._person.hand.body, leg.body, -1) < REACH_M
        self._legs.release(self._person.hand.body if at_leg else None)
        self._signal("leg_offset", offset_of(leg))
        self._signal("leg_held", False)

    def _in_grasp(self, leg: Leg) -> bool:
        place, turn = bullet.multiplyTransforms(*bullet.invertTransform(*self._torso.palm_pose()), *leg.pose())
        axis = bullet.getMatrixFromQuaternion(turn)[2::3]
        along = sum(a * (g - p) for a, g, p in zip(axis, GRASP_POINT_M, place, strict=True))
        nearest = tuple(p + along * a for p, a in zip(place, axis, strict=True))
        return abs(along) < LEG_LENGTH_M / 2 and math.dist(nearest, GRASP_POINT_M) < GRASP_REGION_M

    def _beyond_release(self) -> bool:
        return min(self._fingers.angles()[2::2]) > RELEASE_RAD

    def _clasped(self) -> bool:
        palm = self._engine.distance(self._person.hand.body, self._torso.body, self._torso.palm)
        return palm < CLASP_M and self._person.feels_push()

    def _clasp(self) -> None:
        angles = self._fingers.angles()
        for number in range(2, len(angles)):  # the thumb lies on the leg's end: the four fingers hold it
            opened_rad = angles[number] - CLOSED[number]
            if opened_rad > 0.0:
                self._fingers.push(number, min(CLASP_MAX_N, CLASP_N_RAD[number % 2] * opened_rad))

    def _stand_at(self, goal: tuple[float, ...]) -> bool:
        return self._to_go(goal) < COVERED_RAD and self._fingers.speed() < STAND_RAD_S

    def _to_go(self, goal: tuple[float, ...]) -> float:
        return max(abs(a - g) for a, g in zip(self._fingers.angles(), goal, strict=True))


def offset_of(leg: Leg) -> float:
    """Distance (m, to a micrometre) from a leg's middle to the handover place; SimulationError when not finite."""
    place = leg.pose()[0]
    finite("the leg's place", place)
    return round(math.dist(place, HANDOVER_M), 6)
