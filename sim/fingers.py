"""The left hand's fingers: a body of its own at the palm, asleep while the fingers do not move."""

from __future__ import annotations

from sim.description import hand_description
from sim.drive import DriveMaker, MotorDrive
from sim.engine import Engine, Pose, bullet, finite
from sim.furniture import ROBOT
from sim.torso import PALM

FINGERS = ("thumb", "index_finger", "mid_finger", "anular_finger", "little_finger")
FINGER_JOINTS = tuple(f"left_{finger}{part}_flex" for finger in FINGERS for part in ("", "2"))
OPEN = (-0.05, 0.05, *(-0.05, -0.05) * 4)
CLOSED = (-0.5, 0.4, *(-0.6, -1.25) * 4)
"""Finger angles (rad, in the order of FINGER_JOINTS): stretched, and around a leg. Stretched stays off the joints'
limits: at a limit each joint is one more unknown of the solver."""

TORQUES_NM = (0.4, 0.1) * 5
"""Strongest torques of a finger's first and second joint."""

FINGER_LEVER_M = 0.025
"""From a finger link's centre of mass to its tip."""

_ASLEEP = bullet.ACTIVATION_STATE_ENABLE_SLEEPING | bullet.ACTIVATION_STATE_SLEEP
_AWAKE = bullet.ACTIVATION_STATE_DISABLE_SLEEPING | bullet.ACTIVATION_STATE_WAKE_UP


class Fingers:
    """The ten finger joints, stretched to begin with."""

    def __init__(self, engine: Engine, palm: Pose, drive: DriveMaker = MotorDrive) -> None:
        self._engine = engine
        self.body, self.joints, self.limits_rad = engine.load(hand_description(FINGER_JOINTS, PALM), sleeps=True)
        self.links = tuple(self.joints[name] for name in FINGER_JOINTS)
        self.drive = drive(engine, self.body, self.links, TORQUES_NM)
        engine.let_be_touched(self.body, ROBOT, 0)
        self._palm: Pose | None = None
        self.follow(palm)
        self.drive.put(OPEN)
        self.rest()

    def move(self, goal: tuple[float, ...], duration_s: float) -> None:
        """Start the joints towards `goal` (rad), all to arrive after `duration_s`; they stay awake until `rest`."""
        self._sleep(False)
        self.drive.move(goal, duration_s)

    def rest(self) -> None:
        """The fingers stay as they are, and cost nothing, until they are moved again."""
        self._sleep(True)

    def follow(self, palm: Pose) -> None:
        """Be where the palm is."""
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
        self._engine.check(self.body, self.links[joint])
        finite("force on a finger", (force_n,))
        tip = (0.0, FINGER_LEVER_M, 0.0)
        force = (force_n, 0.0, 0.0)
        bullet.applyExternalForce(
            self.body, self.links[joint], force, tip, bullet.LINK_FRAME, physicsClientId=self._engine.client
        )

    def push_at(self, link: int, force_n: tuple[float, ...], place: tuple[float, ...]) -> None:
        """Press on a finger link for one step: force (N) at a place (m), both in world axes."""
        self._engine.check(self.body, link)
        finite("force on a finger", force_n)
        bullet.applyExternalForce(
            self.body, link, force_n, place, bullet.WORLD_FRAME, physicsClientId=self._engine.client
        )

    def _sleep(self, asleep: bool) -> None:
        self.resting = asleep
        state = _ASLEEP if asleep else _AWAKE
        bullet.changeDynamics(self.body, -1, activationState=state, physicsClientId=self._engine.client)
