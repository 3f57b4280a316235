"""BERT2's torso and left arm up to the palm, with position motors."""

from __future__ import annotations

from collections.abc import Sequence

from controller.ports import ARM_JOINTS, JointPose
from sim.drive import DriveMaker, motors
from sim.engine import Engine, SimulationError, check_finite
from sim.geometry import Pose
from sim.layout import ROBOT
from sim.urdf import arm_description, without_visuals

ARM_TORQUE_NM = 200.0
"""Maximum torque of an arm joint."""

STANDS_RAD_S = 0.001
"""An arm slower than this is at rest."""

PALM = "left_wrist_flex"
ARM_LINKS = ("left_elbow_flex", "left_wrist_pronation", "left_wrist_abduction", PALM)
"""Links of the left arm from the elbow on."""


class Torso:
    """The robot's body in an engine, initially at HOME; its fingers are in `sim.fingers`."""

    def __init__(self, engine: Engine, drive: DriveMaker = motors) -> None:
        self._engine = engine
        self.description = arm_description(ARM_JOINTS, PALM)
        self.body, self.joints, self.limits_rad = engine.load(without_visuals(self.description))
        self.palm = self.joints[PALM]
        arm = [self.joints[name] for name in ARM_JOINTS]
        self.drive = drive(engine, self.body, arm, [ARM_TORQUE_NM] * len(arm))
        engine.set_collision_group(self.body, ROBOT, 0)
        self.drive.reset((0.0,) * len(arm))

    def move_arm(self, goal: JointPose, duration_s: float, ramp_s: float = 0.0) -> None:
        """Start the nine arm joints towards `goal` (rad), all to arrive in `duration_s`, with ramps (see `Drive`).

        Raises:
            SimulationError: not nine finite numbers, a goal outside a joint's limits, or an invalid duration.
        """
        self.check_goal(goal)
        self.drive.move(goal, duration_s, ramp_s)

    def stop_arm(self) -> None:
        """Brake the arm where it is, and hold it there until it is moved again."""
        self.drive.stop()

    def check_goal(self, goal: Sequence[float]) -> None:
        """Raise SimulationError unless `goal` is nine finite angles within the arm's limits."""
        if len(goal) != len(ARM_JOINTS):
            raise SimulationError(f"an arm pose has {len(goal)} angles: expected {len(ARM_JOINTS)}")
        check_finite("arm pose", goal)
        for name, angle in zip(ARM_JOINTS, goal, strict=True):
            lower, upper = self.limits_rad[name]
            if not lower <= angle <= upper:
                raise SimulationError(f"{name} at {angle} rad is outside its limits [{lower}, {upper}]")

    def set_arm(self, pose: JointPose) -> None:
        """Set the arm's pose at once: for collision checks, never in a running world."""
        self.check_goal(pose)
        self.drive.reset(pose)

    def arm_angles(self) -> JointPose:
        """The nine arm joint angles (rad)."""
        return self.drive.angles()

    def stands_at(self, goal: JointPose, tolerance_rad: float) -> bool:
        """True when the arm is at rest with every joint near `goal` (rad)."""
        if self.arm_speed() > STANDS_RAD_S:
            return False
        return all(abs(a - g) < tolerance_rad for a, g in zip(self.arm_angles(), goal, strict=True))

    def arm_speed(self) -> float:
        """The largest joint speed of the arm (rad/s). Raises SimulationError when any is not finite."""
        return self.drive.speed()

    def arm_speeds(self) -> Sequence[float]:
        """The same after each step of the engine's last advance; of the last one only, if steps are not computed."""
        return self.drive.speeds()

    def palm_pose(self) -> Pose:
        """Position (m) and orientation of the palm link's frame: out of the palm, to the fingers, to the thumb."""
        return self._engine.link_frame(self.body, self.palm)

    def palm_mass_pose(self) -> Pose:
        """Pose of the palm's centre of mass: what constraints are relative to."""
        return self._engine.link_mass_frame(self.body, self.palm)

    def from_palm(self, pose: Pose) -> Pose:
        """The pose that is `pose` relative to the palm link's frame."""
        return self._engine.compose(self.palm_pose(), pose)

    def to_palm(self, pose: Pose) -> Pose:
        """A pose relative to the palm link's frame."""
        return self._engine.relative(self.palm_pose(), pose)
