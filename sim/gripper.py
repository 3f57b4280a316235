"""The robot's gripper: closed fingers hold a leg, and release it when they have opened far enough."""

from __future__ import annotations

import math
from collections.abc import Callable
from enum import Enum, auto

from sim.engine import Contact, Engine, check_finite
from sim.fingers import CLOSED, OPEN, Fingers, HandContact
from sim.geometry import UPRIGHT, Vector
from sim.layout import HANDOVER_M, LEG_LENGTH_M
from sim.leg import Leg
from sim.leg_supply import LegSupply
from sim.person import Person
from sim.rotation import matrix_of
from sim.torso import Torso

CLOSE_S = 1.2
OPEN_S = 0.6
"""Duration of a finger movement without obstacle."""

STAND_RAD_S = 0.01
"""Fingers slower than this are at rest."""

COVERED_RAD = 0.01
"""Fingers this near to their goal have reached it. Chosen: from 0.005 to 0.02 the records are the same (see
`sim.world.REST_TICKS`)."""

RELEASE_RAD = -0.30
"""The four fingers' first joints must all have opened beyond this angle before a leg is free: half of CLOSED."""

SEEN_OPEN_RAD = 0.10
"""Fingers are measured to be open when every joint is this near to OPEN. Chosen: from 0.05 to 0.2 the records are the
same (see `sim.world.REST_TICKS`)."""

GRASP_POINT_M = (0.043, 0.10, 0.0)
"""Middle of the grasp, in the palm's frame: one leg radius off the palm, over the roots of the fingers."""

GRASP_HEIGHT_M = 0.09
"""A leg is grasped this far above its middle."""

GRASP_REGION_M = 0.03
"""A leg whose axis passes this near to the grasp point is between the closing fingers. Chosen: from 0.015 to 0.05 the
records are the same (see `sim.world.REST_TICKS`)."""

REACH_M = 0.08
"""The person's hand is at the leg when it is this near to it: then the released leg is taken."""

CLASP_M = 0.15
"""The person's hand can clasp the robot's fingers when it is this near to the palm."""

CLASP_N_RAD = (60.0, 20.0)
CLASP_MAX_N = 30.0
"""A gripping hand resists like a one-sided spring of this stiffness (N at the tip of a finger's first and second link,
per rad of opening): it stops the finger motors well before RELEASE_RAD (tests/sim/test_grasp.py)."""

FORCE_DIGITS = 3
"""Forces are recorded to a millinewton."""

Signal = Callable[[str, float | bool], None]


class FingerMotion(Enum):
    """The movement that the fingers are making."""

    NONE = auto()
    CLOSING = auto()
    OPENING = auto()


class Gripper:
    """Commands to the fingers; grasp and release follow from the fingers' physical positions."""

    def __init__(
        self, engine: Engine, torso: Torso, fingers: Fingers, legs: LegSupply, person: Person, signal: Signal
    ) -> None:
        self._engine = engine
        self._torso = torso
        self._fingers = fingers
        self._legs = legs
        self._person = person
        self._signal = signal
        self._contact = HandContact(engine, torso, fingers, person.hand.body)
        self._distance_m = 0.0  # at the last step of closing
        self._gripped = False
        self.motion = FingerMotion.NONE

    def close(self) -> None:
        """Start to close the fingers."""
        self._fingers.follow(self._torso.palm_pose())
        self._fingers.move(CLOSED, CLOSE_S)
        self.motion = FingerMotion.CLOSING
        if self._distance_to(CLOSED) > COVERED_RAD:
            self._contact.begin()
            self._distance_m = self.human_distance()
            self._signal("hand_distance", self._distance_m)
            self._signal("hand_closing", True)

    def begin_with_leg(self) -> None:
        """At the start of a run: the fingers are closed around the leg that waited, wherever the arm is."""
        leg = self._legs.current
        self._fingers.drive.reset(CLOSED)
        x, y, z = GRASP_POINT_M
        self._engine.place(leg.body, self._torso.from_palm(((x, y, z - GRASP_HEIGHT_M), UPRIGHT)))
        leg.grasp(self._torso)
        self._signal("leg_held", True)

    def open(self) -> None:
        """Start to open the fingers."""
        self._end_closing()
        self._fingers.move(OPEN, OPEN_S)
        self.motion = FingerMotion.OPENING

    @property
    def busy(self) -> bool:
        """True while `before_step` is needed: the fingers move, or a leg is held."""
        return self.motion is not FingerMotion.NONE or self._legs.in_hand is not None

    @property
    def busy_each_step(self) -> bool:
        """True while what `before_step` does differs from step to step."""
        if self.motion is not FingerMotion.NONE or self._gripped:
            return True
        return self._legs.in_hand is not None and self._person.pulls and self._person.pull_changing

    def at_rest(self) -> bool:
        """True when the last command is done."""
        return self.motion is FingerMotion.NONE

    def seen_open(self) -> bool:
        """True when all fingers are measured to be open."""
        return self._distance_to(OPEN) < SEEN_OPEN_RAD

    def human_distance(self) -> float:
        """Smallest distance (m, to a micrometre) between the person's hand and the robot's palm and fingers."""
        return self._contact.distance()

    def nearest_to_human(self) -> Contact:
        """Where palm or fingers are nearest to the person's hand."""
        return self._contact.nearest()

    def before_step(self) -> None:
        """Apply the person's forces on fingers and leg for the next physics step."""
        if self.motion is FingerMotion.CLOSING:
            self._press_on_hand()
        leg = self._legs.in_hand
        if leg is not None:
            pull_n = self._person.pull_now()
            if pull_n:
                leg.pull((pull_n, 0.0, 0.0))
            gripped = self.motion is FingerMotion.OPENING and self._grip_resists()
            if gripped:
                self._apply_grip()
            self._feel_grip(gripped)

    def after_step(self) -> None:
        """What this step's finger positions mean, while the fingers move."""
        self._fingers.follow(self._torso.palm_pose())
        if self.motion is FingerMotion.CLOSING:
            self._distance_m = self.human_distance()
            self._signal("hand_distance", self._distance_m)
        elif self.motion is FingerMotion.OPENING and self._legs.in_hand is not None and self._beyond_release():
            self._let_go(self._legs.in_hand)

    def tick(self) -> None:
        """Once every control tick: has the hand done what it was about?"""
        self._fingers.follow(self._torso.palm_pose())
        held = self._legs.in_hand
        if held is not None and held.torn():
            if self.motion is not FingerMotion.OPENING:  # pulled out of a hand that opens, it is handed over sooner
                self._signal("leg_torn", True)
            self._let_go(held)
        if self.motion is FingerMotion.CLOSING and self._stands_at(CLOSED):
            self._end_closing()
            self._stop()
            leg = self._legs.current
            if leg.graspable and self._in_grasp(leg):
                leg.grasp(self._torso)
                self._signal("leg_torn", False)
                self._signal("leg_held", True)
        elif self.motion is FingerMotion.OPENING and self._stands_at(OPEN):
            self._stop()

    def _feel_grip(self, gripped: bool) -> None:
        if gripped != self._gripped:
            self._gripped = gripped
            self._signal("hand_gripped", gripped)

    def _press_on_hand(self) -> None:
        force_n = 0.0
        if self._distance_m < 0.0:
            self._person.hand.wait()  # whoever feels fingers keeps still until they stop
            self._contact.press()
            force_n = self._contact.force_n
        self._signal("hand_contact_force", round(force_n, FORCE_DIGITS))

    def _end_closing(self) -> None:
        self._signal("hand_closing", False)
        self._signal("hand_contact_force", 0.0)

    def _stop(self) -> None:
        self.motion = FingerMotion.NONE
        self._fingers.rest()

    def _let_go(self, leg: Leg) -> None:
        at_leg = self._engine.distance(self._person.hand.body, leg.body, -1) < REACH_M
        offset_m = offset_of(leg.pose()[0])  # where it left the hand, not where it falls
        self._legs.release(self._person.hand.body if at_leg else None)
        self._feel_grip(False)
        self._signal("leg_offset", offset_m)
        self._signal("leg_held", False)

    def _in_grasp(self, leg: Leg) -> bool:
        place, turn = self._torso.to_palm(leg.pose())
        axis = matrix_of(turn)[2::3]
        along = sum(a * (g - p) for a, g, p in zip(axis, GRASP_POINT_M, place, strict=True))
        nearest = tuple(p + along * a for p, a in zip(place, axis, strict=True))
        return abs(along) < LEG_LENGTH_M / 2 and math.dist(nearest, GRASP_POINT_M) < GRASP_REGION_M

    def _beyond_release(self) -> bool:
        return min(self._fingers.angles()[2::2]) > RELEASE_RAD  # every other one from the third: first joints, no thumb

    def _grip_resists(self) -> bool:
        if self._person.holds_shut:
            return True
        palm = self._engine.distance(self._person.hand.body, self._torso.body, self._torso.palm)
        return palm < CLASP_M and self._person.feels_push()

    def _apply_grip(self) -> None:
        angles = self._fingers.angles()
        for number in range(2, len(angles)):  # the thumb rests on the leg's end: the four fingers hold it
            opened_rad = angles[number] - CLOSED[number]
            if opened_rad > 0.0:
                self._fingers.push(number, min(CLASP_MAX_N, CLASP_N_RAD[number % 2] * opened_rad))

    def _stands_at(self, goal: tuple[float, ...]) -> bool:
        return self._distance_to(goal) < COVERED_RAD and self._fingers.speed() < STAND_RAD_S

    def _distance_to(self, goal: tuple[float, ...]) -> float:
        return max(abs(a - g) for a, g in zip(self._fingers.angles(), goal, strict=True))


def offset_of(place: Vector) -> float:
    """Distance (m, to a micrometre) from a leg's middle to the handover place; SimulationError when not finite."""
    check_finite("the leg's place", place)
    return round(math.dist(place, HANDOVER_M), 6)
