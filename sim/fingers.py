"""The left hand's fingers: a separate body at the palm, asleep while they do not move; their contact with a hand."""

from __future__ import annotations

import math

from sim.drive import DriveMaker, motors
from sim.engine import Contact, Engine
from sim.geometry import Pose, Vector
from sim.layout import ROBOT
from sim.torso import PALM, Torso
from sim.urdf import hand_description

FINGERS = ("thumb", "index_finger", "mid_finger", "anular_finger", "little_finger")
FINGER_JOINTS = tuple(f"left_{finger}{part}_flex" for finger in FINGERS for part in ("", "2"))
OPEN = (-0.05, 0.05, *(-0.05, -0.05) * 4)
CLOSED = (-0.5, 0.4, *(-0.6, -1.25) * 4)
"""Finger angles (rad, in the order of FINGER_JOINTS): stretched, and around a leg. Stretched keeps off the joints'
limits: a joint at its limit adds an unknown to the solver."""

TORQUES_NM = (0.4, 0.1) * 5
"""Strongest torques of a finger's first and second joint."""

FINGER_LEVER_M = 0.025
"""From a finger link's centre of mass to its tip."""

HAND_STIFFNESS_N_M = 1500.0
HAND_MAX_FORCE_N = 30.0
"""Stiffness of a person's hand as a one-sided spring: 5 mm under the 8 N of a finger's motor. It is softer than the
75 N/mm of ISO/TS 15066 for the back of a hand, with which a finger of a few grams is unstable at 120 steps per second;
it still stops a finger. The force is bounded for a finger that is fast."""


class Fingers:
    """The ten finger joints, initially stretched."""

    def __init__(self, engine: Engine, palm: Pose, drive: DriveMaker = motors) -> None:
        self._engine = engine
        self.body, self.joints, self.limits_rad = engine.load(hand_description(FINGER_JOINTS, PALM), may_sleep=True)
        self.links = tuple(self.joints[name] for name in FINGER_JOINTS)
        self.drive = drive(engine, self.body, self.links, TORQUES_NM)
        engine.set_collision_group(self.body, ROBOT, 0)
        self._palm: Pose | None = None
        self.follow(palm)
        self.drive.reset(OPEN)
        self.rest()

    def move(self, goal: tuple[float, ...], duration_s: float) -> None:
        """Start the joints towards `goal` (rad), all to arrive after `duration_s`; they stay awake until `rest`."""
        self._sleep(False)
        self.drive.move(goal, duration_s)

    def rest(self) -> None:
        """Put the fingers to sleep, which costs no computing time, until they are moved again."""
        self._sleep(True)

    def follow(self, palm: Pose) -> None:
        """Move to the palm's pose."""
        if palm != self._palm:
            self._palm = palm
            self._engine.place(self.body, palm)

    def angles(self) -> tuple[float, ...]:
        """The joint angles (rad), in the order of FINGER_JOINTS."""
        return self.drive.angles()

    def speed(self) -> float:
        """The fastest joint's speed (rad/s); 0 while they rest."""
        return 0.0 if self.resting else self.drive.speed()

    def push(self, joint: int, force_n: float) -> None:
        """Press the tip of a finger link towards the palm's front for one step: force (N) across the link."""
        tip = (0.0, FINGER_LEVER_M, 0.0)
        self._engine.push_link(self.body, self.links[joint], (force_n, 0.0, 0.0), tip)

    def push_at(self, link: int, force_n: Vector, place: Vector) -> None:
        """Press on a finger link for one step: force (N) at a place (m), both in world axes."""
        self._engine.push(self.body, link, force_n, place)

    def _sleep(self, asleep: bool) -> None:
        self.resting = asleep
        self._engine.sleep(self.body, asleep)


class HandContact:
    """Distances and forces between the robot's left hand and the person's hand (a body)."""

    def __init__(self, engine: Engine, torso: Torso, fingers: Fingers, hand: int) -> None:
        self._engine = engine
        self._torso = torso
        self._fingers = fingers
        self._hand = hand
        self._unpressed_m = dict.fromkeys(fingers.links, math.inf)
        self.force_n = 0.0

    def begin(self) -> None:
        """The fingers begin to close.

        Only then do they press. Open ones pass through a hand, so what they overlap with at first presses on nobody.
        """
        self._unpressed_m = dict.fromkeys(self._fingers.links, math.inf)

    def distance(self) -> float:
        """Smallest distance (m, to a micrometre) between the person's hand and the robot's palm and fingers."""
        fingers = self._engine.distance_to_all(self._hand, self._fingers.body)
        return round(min(fingers, self._engine.distance(self._hand, self._torso.body, self._torso.palm)), 6)

    def nearest(self) -> Contact:
        """Where the robot's palm or a finger is nearest to the person's hand."""
        links = [(self._torso.body, self._torso.palm), *((self._fingers.body, link) for link in self._fingers.links)]
        return max((self._engine.deepest(*link, self._hand) for link in links), key=lambda contact: contact.depth_m)

    def press(self) -> None:
        """Push fingers out of the person's hand for the next physics step; `force_n` becomes the sum of forces (N)."""
        self.force_n = 0.0
        for link in self._fingers.links:
            depth_m, place, (x, y, z) = self._engine.deepest(self._fingers.body, link, self._hand)
            self._unpressed_m[link] = unpressed_m = min(self._unpressed_m[link], max(0.0, depth_m))
            if depth_m > unpressed_m:
                force_n = min(HAND_MAX_FORCE_N, HAND_STIFFNESS_N_M * (depth_m - unpressed_m))
                self._fingers.push_at(link, (force_n * x, force_n * y, force_n * z), place)
                self.force_n += force_n
