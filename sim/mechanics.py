"""The two fidelities of the world, behind one interface: how joints and legs move in a step.

`dynamic`: motors, masses, gravity, contacts. `kinematic`: joints follow the plan and a leg follows the hand that holds
it; nothing has mass. Kinematic runs find faults of the planner and of the controller's logic; they show nothing about
forces, slips, grips that hold the fingers, or speeds other than the planned ones.

To add another physics engine, implement `sim.engine.Engine` and list it in `sim.engines`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from sim.drive import Joints, Move
from sim.engine import STEP_S, Drive, Engine, SimulationError, check_finite
from sim.geometry import UPRIGHT, Pose, Vector
from sim.layout import LEG_LENGTH_M, LEG_MASS_KG, height_below
from sim.leg import Held, Leg, RigidLeg
from sim.torso import Torso

GRAVITY_M_S2 = 9.81


class Mechanics(Protocol):
    """Creates the moving parts of a world and moves them.

    `by_tick`: nothing happens between two control ticks.
    """

    by_tick: bool

    def drive(self, engine: Engine, body: int, indices: Sequence[int], torques_nm: Sequence[float]) -> Drive:
        """A drive for some joints of a body."""

    def leg(self, engine: Engine, place: Vector) -> Leg:
        """A leg that waits at a place (m)."""

    def advance(self, engine: Engine, steps: int) -> int:
        """Advance by physics steps: at least one, at most `steps`. Returns how many were made."""


class Dynamic:
    """The engine's rigid bodies, motors and joints."""

    by_tick = False

    def drive(self, engine: Engine, body: int, indices: Sequence[int], torques_nm: Sequence[float]) -> Drive:
        """See `Mechanics`."""
        return engine.drive(body, indices, torques_nm)

    def leg(self, engine: Engine, place: Vector) -> Leg:
        """See `Mechanics`."""
        return RigidLeg(engine, place)

    def advance(self, engine: Engine, steps: int) -> int:
        """See `Mechanics`."""
        return engine.advance(steps)


class Kinematic:
    """Everything follows its plan or its holder exactly, computed once every control tick."""

    by_tick = True  # nothing has mass

    def __init__(self) -> None:
        self._moved: list[KinematicDrive | KinematicLeg] = []

    def drive(self, engine: Engine, body: int, indices: Sequence[int], torques_nm: Sequence[float]) -> Drive:
        """See `Mechanics`."""
        drive = KinematicDrive(engine, body, indices)
        self._moved.insert(0, drive)  # joints move before the legs that follow them
        return drive

    def leg(self, engine: Engine, place: Vector) -> Leg:
        """See `Mechanics`."""
        leg = KinematicLeg(engine, place)
        self._moved.append(leg)
        return leg

    def advance(self, engine: Engine, steps: int) -> int:
        """See `Mechanics`."""
        for mover in self._moved:
            mover.advance(steps)
        return steps


class KinematicDrive(Joints):
    """A `Drive` whose joints follow the plan exactly."""

    def __init__(self, engine: Engine, body: int, indices: Sequence[int]) -> None:
        super().__init__(engine, body, indices)
        self._move: Move | None = None
        self._steps = 0

    def move(self, goal: Sequence[float], duration_s: float, ramp_s: float = 0.0) -> None:
        """See `Drive`."""
        self._move, self._steps = Move(self.angles(), tuple(goal), duration_s, ramp_s), 0

    def stop(self) -> None:
        """See `Drive`."""
        self._move = None

    def reset(self, pose: Sequence[float]) -> None:
        """See `Drive`."""
        check_finite("pose", pose)
        self._move = None
        self._set(pose)

    def speed(self) -> float:
        """The planned speed (rad/s) of the fastest joint; 0 at the goal."""
        move = self._move
        return 0.0 if move is None else max(move.top_speeds_rad_s) * move.speed_share(self._steps * STEP_S)

    def advance(self, steps: int) -> None:
        """Go so many steps of the way."""
        move = self._move
        if move is None:
            return
        self._steps += steps
        share = move.distance_share(self._steps * STEP_S)
        self._set([start + share * (goal - start) for start, goal in zip(move.start, move.goal, strict=True)])
        if self._steps * STEP_S >= move.duration_s:
            self._move = None


class KinematicLeg(Leg):
    """A leg that follows its holder exactly, or stands upright on the surface below."""

    def __init__(self, engine: Engine, place: Vector) -> None:
        super().__init__(engine, place)
        self._carrier: Callable[[], Pose] | None = None
        self._frame: Pose = ((0.0, 0.0, 0.0), UPRIGHT)
        self._pull: Vector = (0.0, 0.0, 0.0)
        self._felt: Vector = (0.0, 0.0, 0.0)

    def grasp(self, torso: Torso) -> None:
        """The robot's palm holds the leg in its present pose."""
        self._attach(torso.palm_pose, Held.ROBOT)

    def torn(self) -> bool:
        """True while the pull exceeds the grasp."""
        # The full grasp carries the weight besides the pull, a weakened one has to be told of both.
        return math.hypot(*(self.reaction() if self.slippery else self._felt)) > self.grasp_n

    def take(self, hand: int) -> None:
        """Only the person's hand holds the leg, in its present pose."""
        self._attach(lambda: self._engine.pose(hand), Held.PERSON)

    def drop(self) -> None:
        """Stand on the surface below, at once."""
        x, y, _ = place = self.pose()[0]
        self._engine.place(self.body, ((x, y, height_below(place) + LEG_LENGTH_M / 2), UPRIGHT))
        self._carrier, self.held = None, Held.LOOSE

    def finish(self) -> None:
        """Let the leg stay where it is for good."""
        self._carrier, self.held = None, Held.DONE

    def pull(self, force_n: Vector) -> None:
        """Pull at the leg for one step."""
        check_finite("pull on the leg", force_n)
        self._pull = force_n

    def reaction(self) -> Vector:
        """Force of the leg on the robot's palm (N, world axes): its weight and the pull."""
        self._check_felt()
        x, y, z = self._felt
        return (x, y, z - LEG_MASS_KG * GRAVITY_M_S2)

    def speed(self) -> float:
        """0: nothing moves by itself."""
        return 0.0

    def advance(self, steps: int) -> None:
        """Follow the holder, whatever the number of steps."""
        self._felt, self._pull = self._pull, (0.0, 0.0, 0.0)
        if self._carrier is not None:
            self._engine.place(self.body, self._engine.compose(self._carrier(), self._frame))

    def _attach(self, carrier: Callable[[], Pose], held: Held) -> None:
        self._frame = self._engine.relative(carrier(), self.pose())
        self._carrier, self.held = carrier, held


FIDELITIES: Mapping[str, Callable[[], Mechanics]] = {"dynamic": Dynamic, "kinematic": Kinematic}


def mechanics_of(fidelity: str) -> Mechanics:
    """The mechanics of a fidelity. Raises SimulationError for an unknown one."""
    if fidelity not in FIDELITIES:
        raise SimulationError(f"fidelity {fidelity!r}: expected one of {', '.join(FIDELITIES)}")
    return FIDELITIES[fidelity]()
