"""A table leg and its holder: a pin at the pickup place, the robot's palm, the person's hand, or nothing."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from enum import Enum, auto

from sim.engine import UPRIGHT, Engine, Pose, SimulationError, Vector, bullet, check_finite
from sim.layout import FURNITURE, LEG, LEG_LENGTH_M, LEG_MASS_KG, LEG_RADIUS_M
from sim.torso import Torso

GRASP_FORCE_N = 15.0
"""Maximum force of the grasp: more than the leg's weight in every arm move plus a pull of 10 N
(tests/sim/test_grasp.py). With a larger force the leg slips."""

TORN_M = 0.02
"""A leg that has slipped this far is out of the fingers; below the maximum force it slips by less than 2 mm."""

CARRY_FORCE_N = 200.0
"""Maximum force with which a person's hand holds a leg."""

STILL_M_S = 5e-3
"""A leg slower than this is at rest."""

SURFACE = {
    "linearDamping": 0.0,
    "angularDamping": 0.1,
    "lateralFriction": 0.6,
    "rollingFriction": 0.002,
    "spinningFriction": 0.002,
}
"""Friction of wood on wood, and a small air drag."""

BEECH = (0.85, 0.65, 0.38, 1.0)


class Held(Enum):
    """What holds a leg."""

    PINNED = auto()
    ROBOT = auto()
    PERSON = auto()
    LOOSE = auto()
    DONE = auto()  # fell or was put down, and does not move any more


class Leg(ABC):
    """One leg, initially standing at `place` (m)."""

    def __init__(self, engine: Engine, place: Vector) -> None:
        self._engine = engine
        self._client = engine.client
        self.held = Held.PINNED
        self.grasp_n = GRASP_FORCE_N
        self.body = self._make((place, UPRIGHT), 0.0)

    @property
    def graspable(self) -> bool:
        """True while nobody holds it."""
        return self.held in (Held.PINNED, Held.LOOSE)

    @property
    def slippery(self) -> bool:
        """True while the robot holds it with less than the full force of its grasp."""
        return self.held is Held.ROBOT and self.grasp_n < GRASP_FORCE_N

    def weaken(self, grasp_n: float) -> None:
        """The robot's grasp holds this leg with at most this force (N) from now on."""
        check_finite("force of a grasp", (grasp_n,))
        if not 0.0 < grasp_n <= GRASP_FORCE_N:
            raise SimulationError(f"grasp of {grasp_n} N: expected more than 0 and at most {GRASP_FORCE_N} N")
        self.grasp_n = grasp_n

    def pose(self) -> Pose:
        """Position (m) of the middle and orientation of the leg (its axis is z)."""
        return self._engine.pose(self.body)

    @abstractmethod
    def speed(self) -> float:
        """Speed of the middle (m/s)."""

    @abstractmethod
    def grasp(self, torso: Torso) -> None:
        """The robot's palm holds the leg in its present pose."""

    @abstractmethod
    def torn(self) -> bool:
        """True when a leg that the robot holds was pulled out of its closed hand."""

    @abstractmethod
    def take(self, hand: int) -> None:
        """Only the person's hand holds the leg, in its present pose."""

    @abstractmethod
    def drop(self) -> None:
        """Nobody holds the leg: it falls."""

    @abstractmethod
    def finish(self) -> None:
        """The leg does not move any more."""

    @abstractmethod
    def pull(self, force_n: Vector) -> None:
        """Pull at the middle of the leg for one step."""

    @abstractmethod
    def reaction(self) -> Vector:
        """Force of the leg on the robot's palm (N, world axes).

        Raises:
            SimulationError: the robot does not hold this leg.
        """

    def _check_felt(self) -> None:
        if self.held is not Held.ROBOT:
            raise SimulationError(f"the robot feels no leg that is {self.held.name.lower()}")

    def _make(self, pose: Pose, mass_kg: float) -> int:
        """A body that physics moves, or (mass 0) one that stands and costs nothing in a step."""
        place, turn = pose
        body = self._engine.add(
            mass_kg, place, BEECH, shapeType=bullet.GEOM_CYLINDER, radius=LEG_RADIUS_M, height=LEG_LENGTH_M
        )
        self._engine.place(body, (place, turn))
        # Standing bodies need no contacts with each other: a standing leg counts as furniture.
        group, by = (LEG, LEG | FURNITURE) if mass_kg else (FURNITURE, LEG)
        bullet.setCollisionFilterGroupMask(body, -1, group, by, physicsClientId=self._client)
        bullet.changeDynamics(body, -1, **SURFACE, physicsClientId=self._client)
        return body


class RigidLeg(Leg):
    """A leg with mass: a joint connects it to its holder; without holder it falls and rests."""

    def __init__(self, engine: Engine, place: Vector) -> None:
        super().__init__(engine, place)
        self._constraint = -1
        self._grasp: tuple[Torso, Pose] | None = None  # the palm, and the leg's pose relative to it

    def speed(self) -> float:
        """Speed of the middle (m/s)."""
        velocity = bullet.getBaseVelocity(self.body, physicsClientId=self._client)[0]
        return float(sum(part * part for part in velocity) ** 0.5)

    def weaken(self, grasp_n: float) -> None:
        """See `Leg`: the joint in the palm gives way beyond this force."""
        super().weaken(grasp_n)
        if self.held is Held.ROBOT:
            bullet.changeConstraint(self._constraint, maxForce=grasp_n, physicsClientId=self._client)

    def grasp(self, torso: Torso) -> None:
        """Join the leg to the robot's palm in its present pose, and remove the pin."""
        if self.held is Held.PINNED:
            self._remake(LEG_MASS_KG)
        frame = _relative(torso.palm_mass_pose(), self.pose())
        joint = self._join(torso.body, torso.palm, frame)
        bullet.changeConstraint(joint, maxForce=self.grasp_n, physicsClientId=self._client)
        self._let_go()
        self._constraint, self._grasp, self.held = joint, (torso, frame), Held.ROBOT

    def torn(self) -> bool:
        """True when the leg has slipped out of the robot's grasp."""
        if self._grasp is None:
            return False
        torso, (grasped, _) = self._grasp
        return math.dist(_relative(torso.palm_mass_pose(), self.pose())[0], grasped) > TORN_M

    def take(self, hand: int) -> None:
        """Join the leg to the person's hand only, in its present pose."""
        if self.held is Held.PINNED:
            self._remake(LEG_MASS_KG)
        frame = _relative(self._engine.pose(hand), self.pose())
        self._let_go()
        self._constraint = self._join(hand, -1, frame)
        bullet.changeConstraint(self._constraint, maxForce=CARRY_FORCE_N, physicsClientId=self._client)
        self.held = Held.PERSON

    def drop(self) -> None:
        """Remove the joint: the leg falls."""
        self._let_go()
        self.held = Held.LOOSE

    def finish(self) -> None:
        """Fix the leg where it is."""
        self._let_go()
        self._remake(0.0)
        self.held = Held.DONE

    def pull(self, force_n: Vector) -> None:
        """Pull at the middle of the leg for one step."""
        check_finite("pull on the leg", force_n)
        bullet.applyExternalForce(
            self.body, -1, force_n, self.pose()[0], bullet.WORLD_FRAME, physicsClientId=self._client
        )

    def reaction(self) -> Vector:
        """The exact force (N, world axes) of the joint that holds it."""
        self._check_felt()
        force = bullet.getConstraintState(self._constraint, physicsClientId=self._client)
        check_finite("reaction of the held leg", force)
        return (force[0], force[1], force[2])

    def _join(self, body: int, link: int, frame: Pose) -> int:
        self._engine.check(body, link)
        joint: int = bullet.createConstraint(
            body,
            link,
            self.body,
            -1,
            bullet.JOINT_FIXED,
            (0.0, 0.0, 0.0),
            frame[0],
            (0.0, 0.0, 0.0),
            frame[1],
            UPRIGHT,
            physicsClientId=self._client,
        )
        if joint < 0:
            raise SimulationError(f"PyBullet refused to join the leg to body {body}, link {link}")
        return joint

    def _remake(self, mass_kg: float) -> None:
        """Replace the body by one with another mass at the same pose: when the leg begins or ceases to move."""
        pose = self.pose()
        self._engine.remove(self.body)
        self.body = self._make(pose, mass_kg)

    def _let_go(self) -> None:
        if self._constraint >= 0:
            bullet.removeConstraint(self._constraint, physicsClientId=self._client)
        self._constraint, self._grasp = -1, None


def _relative(base: Pose, other: Pose) -> Pose:
    """`other` relative to `base`."""
    back = bullet.invertTransform(*base)
    pose: Pose = bullet.multiplyTransforms(*back, *other)
    return pose
