"""A scene for looking at arm poses: robot and furniture, without legs and people, apart from the running world."""

from __future__ import annotations

import math

from controller.ports import JointPose
from sim.engine import Engine, SimulationError, bullet
from sim.fingers import Fingers
from sim.furniture import furnish
from sim.torso import Torso

SAMPLE_RAD = 0.04
"""Between two looks at the arm no joint turns further than this: at most 3 cm at the fingertips."""

CLEARANCE_M = 0.02
"""Nearest that the left arm may come to table, bin or torso."""

ARM_LINKS = ("left_elbow_flex", "left_wrist_pronation", "left_wrist_abduction", "left_wrist_flex")
TORSO_LINKS = ("hip_flexor",)
"""Links that the left arm must not meet: the braced neck, head and right arm are part of the hip flexor's link."""


class Scene:
    """Robot and furniture in an engine of their own."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._furniture = furnish(engine)[1:]  # nothing of the arm reaches the floor
        self.torso = Torso(engine)
        self._fingers = Fingers(engine, self.torso.palm_pose())
        self._moving = {
            self.torso.body: {self.torso.joints[name]: name for name in ARM_LINKS},
            self._fingers.body: {index: name for name, index in self._fingers.joints.items()},
        }
        self._standing = (-1, *(self.torso.joints[name] for name in TORSO_LINKS))

    def touched(self, pose: JointPose) -> str:
        """What the arm comes too near to in `pose`, or an empty text."""
        self.torso.set_arm(pose)
        self._fingers.follow(self.torso.palm_pose())
        for body, names in self._moving.items():
            for other in self._furniture:
                for link, distance_m in self._near(body, other):
                    if link in names:
                        return f"{names[link]} comes within {distance_m:.3f} m of table or bin"
            for link, name in names.items():
                for other in self._standing:
                    for _, distance_m in self._near(body, self.torso.body, link, other):
                        return f"{name} comes within {distance_m:.3f} m of the torso"
        return ""

    def _near(self, body: int, other: int, *links: int) -> list[tuple[int, float]]:
        """Link of the robot and distance (m) of every pair nearer than CLEARANCE_M."""
        points = bullet.getClosestPoints(body, other, CLEARANCE_M, *links, physicsClientId=self._engine.client)
        return [(point[3], point[8]) for point in points]

    def beyond(self, pose: JointPose) -> str:
        """Which joint's limits `pose` leaves, or an empty text."""
        try:
            self.torso.check_goal(pose)
        except SimulationError as error:
            return str(error)
        return ""

    def blocked(self, start: JointPose, goal: JointPose) -> str:
        """What is in the way straight from `start` to `goal`, and where; or an empty text. `start` is not looked at."""
        looks = 1 + math.ceil(max(abs(g - s) for g, s in zip(goal, start, strict=True)) / SAMPLE_RAD)
        for look in range(1, looks + 1):
            touched = self.touched(tuple(s + look / looks * (g - s) for g, s in zip(goal, start, strict=True)))
            if touched:
                return f"{touched} at {look / looks:.0%} of the way"
        return ""
