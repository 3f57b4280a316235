"""The robot: BERT2's torso, left arm and left hand, with position motors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from controller.ports import ARM_JOINTS, JointPose
from sim.engine import Engine, Pose, SimulationError, bullet, finite
from sim.furniture import ROBOT

URDF = Path(__file__).with_name("bert2.urdf")

ARM_FORCE_NM = 200.0
FINGER_FORCE_NM = (0.4, 0.1)
POSITION_GAIN = 0.3
VELOCITY_GAIN = 1.0
"""Strongest torques (of a finger: its first and second joint), and motor settings whose measured speed is the planned
one with one call a joint and move (tests/sim/test_robot.py)."""

HOLD_SPEED_RAD_S = 0.02
"""Top speed of a joint that is to stay where it is: it may correct itself, and slowly."""

STANDS_RAD_S = 0.001
"""An arm slower than this stands."""

FINGERS = ("thumb", "index_finger", "mid_finger", "anular_finger", "little_finger")
FINGER_JOINTS = tuple(f"left_{finger}{part}_flex" for finger in FINGERS for part in ("", "2"))
OPEN: JointPose = (-0.05, 0.05, *(-0.05, -0.05) * 4)
CLOSED: JointPose = (-0.5, 0.4, *(-0.6, -1.25) * 4)
"""Finger angles (rad, in the order of FINGER_JOINTS): stretched, and around a leg. Stretched stays off the joints'
limits: at a limit each joint is one more unknown of the solver, and a step takes half as long again."""

FINGER_LEVER_M = 0.025
"""From a finger link's centre of mass to its tip."""

PALM = "left_wrist_flex"


class Torso:
    """The robot's body in an engine, at HOME with open fingers."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._client = engine.client
        self.body = engine.load(str(URDF))
        self.joints: dict[str, int] = {}
        self.limits_rad: dict[str, tuple[float, float]] = {}
        for index in range(bullet.getNumJoints(self.body, physicsClientId=self._client)):
            info = bullet.getJointInfo(self.body, index, physicsClientId=self._client)
            name = info[1].decode().removesuffix("_joint")
            self.joints[name] = index
            self.limits_rad[name] = (info[8], info[9])
        self.arm = self._indices(ARM_JOINTS)
        self.fingers = self._indices(FINGER_JOINTS)
        self.palm = self._indices((PALM,))[0]
        self.hand_links = (self.palm, *self.fingers)
        self._all = tuple(self.joints.values())
        self._prepare()

    def move_arm(self, goal: JointPose, duration_s: float) -> None:
        """Start the nine arm joints towards `goal` (rad), all to arrive in `duration_s`.

        Raises:
            SimulationError: not nine finite numbers, a goal outside a joint's limits, or no positive duration.
        """
        self.check_goal(goal)
        finite("duration of an arm move", (duration_s,))
        if duration_s <= 0.0:
            raise SimulationError(f"duration of an arm move is {duration_s!r} s: expected more than 0")
        for index, angle, now in zip(self.arm, goal, self.arm_angles(), strict=True):
            self._motor(index, angle, ARM_FORCE_NM, max(abs(angle - now) / duration_s, HOLD_SPEED_RAD_S))

    def move_fingers(self, goal: JointPose, duration_s: float) -> None:
        """Start the ten finger joints towards `goal` (rad)."""
        finite("goal and duration of a finger move", (*goal, duration_s))
        fingers = enumerate(zip(self.fingers, goal, self.finger_angles(), strict=True))
        for number, (index, angle, now) in fingers:
            speed_rad_s = max(abs(angle - now) / duration_s, HOLD_SPEED_RAD_S)
            self._motor(index, angle, FINGER_FORCE_NM[number % 2], speed_rad_s)

    def check_goal(self, goal: Sequence[float]) -> None:
        """Raise SimulationError unless `goal` is nine finite angles within the arm's limits."""
        if len(goal) != len(ARM_JOINTS):
            raise SimulationError(f"an arm pose has {len(goal)} angles: expected {len(ARM_JOINTS)}")
        finite("arm pose", goal)
        for name, angle in zip(ARM_JOINTS, goal, strict=True):
            lower, upper = self.limits_rad[name]
            if not lower <= angle <= upper:
                raise SimulationError(f"{name} at {angle} rad is outside its limits [{lower}, {upper}]")

    def set_arm(self, pose: JointPose) -> None:
        """Put the arm somewhere at once: for looking at a pose, never in a running world."""
        self.check_goal(pose)
        for index, angle in zip(self.arm, pose, strict=True):
            bullet.resetJointState(self.body, index, angle, 0.0, physicsClientId=self._client)

    def arm_angles(self) -> JointPose:
        """The nine arm joint angles (rad)."""
        return self._angles(self.arm)

    def stands_at(self, goal: JointPose, tolerance_rad: float) -> bool:
        """True when the arm stands with every joint near to `goal` (rad)."""
        if self.arm_speed() > STANDS_RAD_S:
            return False
        return all(abs(a - g) < tolerance_rad for a, g in zip(self.arm_angles(), goal, strict=True))

    def finger_angles(self) -> JointPose:
        """The ten finger joint angles (rad), in the order of FINGER_JOINTS."""
        return self._angles(self.fingers)

    def arm_speed(self) -> float:
        """The largest joint speed of the arm (rad/s). Raises SimulationError when any is not finite."""
        return self._speed(self.arm)

    def finger_speed(self) -> float:
        """The largest joint speed of the fingers (rad/s)."""
        return self._speed(self.fingers)

    def joint_speed(self) -> float:
        """The largest joint speed of the whole robot (rad/s)."""
        return self._speed(self._all)

    def palm_pose(self) -> Pose:
        """Position (m) and orientation of the palm link's frame: out of the palm, to the fingers, to the thumb."""
        state = bullet.getLinkState(self.body, self.palm, physicsClientId=self._client)
        return state[4], state[5]

    def palm_mass_pose(self) -> Pose:
        """Pose of the palm's centre of mass: what constraints are relative to."""
        state = bullet.getLinkState(self.body, self.palm, physicsClientId=self._client)
        return state[0], state[1]

    def push(self, finger_joint: int, force_n: float) -> None:
        """Press the tip of a finger link towards the palm's front for one step: force (N) across the link."""
        self._engine.check(self.body, self.fingers[finger_joint])
        finite("force on a finger", (force_n,))
        link = self.fingers[finger_joint]
        tip = (0.0, FINGER_LEVER_M, 0.0)
        bullet.applyExternalForce(
            self.body, link, (force_n, 0.0, 0.0), tip, bullet.LINK_FRAME, physicsClientId=self._client
        )

    def _motor(self, index: int, goal_rad: float, force_nm: float, top_speed_rad_s: float) -> None:
        bullet.setJointMotorControl2(
            self.body,
            index,
            bullet.POSITION_CONTROL,
            goal_rad,
            force=force_nm,
            positionGain=POSITION_GAIN,
            velocityGain=VELOCITY_GAIN,
            maxVelocity=top_speed_rad_s,
            physicsClientId=self._client,
        )

    def _angles(self, indices: tuple[int, ...]) -> JointPose:
        states = bullet.getJointStates(self.body, indices, physicsClientId=self._client)
        return tuple(state[0] for state in states)

    def _speed(self, indices: tuple[int, ...]) -> float:
        states = bullet.getJointStates(self.body, indices, physicsClientId=self._client)
        speeds = [abs(state[1]) for state in states]
        if not math.isfinite(sum(speeds)):
            raise SimulationError(f"joint speeds of the robot are {speeds!r}: expected finite numbers")
        return float(max(speeds))

    def _indices(self, names: Sequence[str]) -> tuple[int, ...]:
        missing = [name for name in names if name not in self.joints]
        if missing:
            raise SimulationError(f"{URDF.name} has no joints {missing}; it has {sorted(self.joints)}")
        return tuple(self.joints[name] for name in names)

    def _prepare(self) -> None:
        for link in (-1, *self._all):
            bullet.setCollisionFilterGroupMask(self.body, link, ROBOT, 0, physicsClientId=self._client)
            bullet.changeDynamics(self.body, link, linearDamping=0.0, angularDamping=0.0, physicsClientId=self._client)
        for index in self._all:
            self._motor(index, 0.0, ARM_FORCE_NM, HOLD_SPEED_RAD_S)
        for number, (index, angle) in enumerate(zip(self.fingers, OPEN, strict=True)):
            bullet.resetJointState(self.body, index, angle, 0.0, physicsClientId=self._client)
            self._motor(index, angle, FINGER_FORCE_NM[number % 2], HOLD_SPEED_RAD_S)
