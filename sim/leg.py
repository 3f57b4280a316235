"""A table leg and its holder: a pin at the pickup place, the robot's palm, the person's hand, or nothing."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from enum import Enum, auto

from sim.engine import Engine, SimulationError, check_finite
from sim.geometry import UPRIGHT, Pose, Vector
from sim.layout import FURNITURE, LEG, LEG_LENGTH_M, LEG_MASS_KG, LEG_RADIUS_M
from sim.shapes import Cylinder, Surface
from sim.torso import Torso

GRASP_FORCE_N = 15.0
"""Maximum force of the grasp: more than the leg's weight in every arm move plus a pull of 10 N
(tests/sim/test_grasp.py). With a larger force the leg slips."""

TORN_M = 0.02
"""A leg that has slipped this far is out of the fingers; below the maximum force it slips by less than 2 mm."""

CARRY_FORCE_N = 200.0
"""Maximum force with which a person's hand holds a leg: forty times its weight, so that it never gives way."""

STILL_M_S = 5e-3
"""A leg slower than this is at rest. Chosen: from 5e-4 to 2e-2 the records are the same (see
`sim.world.REST_TICKS`)."""

SURFACE = Surface(lateral=0.6, rolling=0.002, spinning=0.002, angular_drag=0.1)
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
        body = self._engine.add(mass_kg, place, BEECH, Cylinder(LEG_RADIUS_M, LEG_LENGTH_M))
        self._engine.place(body, (place, turn))
        # Standing bodies need no contacts with each other: a standing leg counts as furniture.
        group, by = (LEG, LEG | FURNITURE) if mass_kg else (FURNITURE, LEG)
        self._engine.set_collision_group(body, group, by)
        self._engine.set_surface(body, SURFACE)
        return body


class RigidLeg(Leg):
    """A leg with mass: a weld connects it to its holder; without holder it falls and rests."""

    def __init__(self, engine: Engine, place: Vector) -> None:
        super().__init__(engine, place)
        self._weld = -1
        self._grasp: tuple[Torso, Pose] | None = None  # the palm, and the leg's pose relative to it

    def speed(self) -> float:
        """Speed of the middle (m/s)."""
        return self._engine.body_speed(self.body)

    def weaken(self, grasp_n: float) -> None:
        """See `Leg`: the weld in the palm gives way beyond this force."""
        super().weaken(grasp_n)
        if self.held is Held.ROBOT:
            self._engine.set_weld_force(self._weld, grasp_n)

    def grasp(self, torso: Torso) -> None:
        """Join the leg to the robot's palm in its present pose, and remove the pin."""
        if self.held is Held.PINNED:
            self._remake(LEG_MASS_KG)
        frame = self._engine.relative(torso.palm_mass_pose(), self.pose())
        weld = self._engine.weld(torso.body, torso.palm, self.body, frame, self.grasp_n)
        self._let_go()
        self._weld, self._grasp, self.held = weld, (torso, frame), Held.ROBOT

    def torn(self) -> bool:
        """True when the leg has slipped out of the robot's grasp."""
        if self._grasp is None:
            return False
        torso, (grasped, _) = self._grasp
        return math.dist(self._engine.relative(torso.palm_mass_pose(), self.pose())[0], grasped) > TORN_M

    def take(self, hand: int) -> None:
        """Join the leg to the person's hand only, in its present pose."""
        if self.held is Held.PINNED:
            self._remake(LEG_MASS_KG)
        frame = self._engine.relative(self._engine.pose(hand), self.pose())
        self._let_go()
        self._weld = self._engine.weld(hand, -1, self.body, frame, CARRY_FORCE_N)
        self.held = Held.PERSON

    def drop(self) -> None:
        """Remove the weld: the leg falls."""
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
        self._engine.push(self.body, -1, force_n, self.pose()[0])

    def reaction(self) -> Vector:
        """The exact force (N, world axes) of the weld that holds it."""
        self._check_felt()
        return self._engine.weld_force(self._weld)

    def _remake(self, mass_kg: float) -> None:
        """Replace the body by one with another mass at the same pose: when the leg begins or ceases to move."""
        pose = self.pose()
        self._engine.remove(self.body)
        self.body = self._make(pose, mass_kg)

    def _let_go(self) -> None:
        if self._weld >= 0:
            self._engine.unweld(self._weld)
        self._weld, self._grasp = -1, None
