"""The world without dynamics: joints go along their plan, a leg is where its holder has it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from sim.drive import Drive, Joints, Move
from sim.engine import UPRIGHT, Engine, Pose, Vector, bullet, finite
from sim.leg import GRASP_FORCE_N, Held, Leg
from sim.physics_time import STEP_S, TICK_STEPS
from sim.places import LEG_LENGTH_M, LEG_MASS_KG, height_below
from sim.torso import Torso

GRAVITY_M_S2 = 9.81


class Kinematic:
    """Everything follows its plan or its holder exactly, looked at once every control tick."""

    stride = TICK_STEPS

    def __init__(self) -> None:
        self._moved: list[PlanDrive | HeldLeg] = []

    def drive(self, engine: Engine, body: int, indices: Sequence[int], torques_nm: Sequence[float]) -> Drive:
        """See `sim.mechanics.Mechanics`."""
        drive = PlanDrive(engine, body, indices)
        self._moved.insert(0, drive)  # joints before the legs that follow them
        return drive

    def leg(self, engine: Engine, place: Vector) -> Leg:
        """See `sim.mechanics.Mechanics`."""
        leg = HeldLeg(engine, place)
        self._moved.append(leg)
        return leg

    def step(self, engine: Engine, steps: int) -> None:
        """See `sim.mechanics.Mechanics`."""
        for each in self._moved:
            each.advance(steps)


class PlanDrive(Joints):
    """A `Drive` whose joints are where the plan says."""

    def __init__(self, engine: Engine, body: int, indices: Sequence[int]) -> None:
        super().__init__(engine, body, indices)
        self._move: Move | None = None
        self._steps = 0

    def move(self, goal: Sequence[float], duration_s: float, ramp_s: float = 0.0) -> None:
        """See `Drive`."""
        self._move, self._steps = Move(self.angles(), tuple(goal), duration_s, ramp_s), 0

    def put(self, pose: Sequence[float]) -> None:
        """See `Drive`."""
        finite("pose", pose)
        self._move = None
        self._set(pose)

    def speed(self) -> float:
        """The planned speed (rad/s) of the fastest joint; 0 at the goal."""
        move = self._move
        return 0.0 if move is None else max(move.top_speeds_rad_s) * move.speed_share(self._steps * STEP_S)

    def advance(self, steps: int) -> None:
        """See `Drive`: so many steps of the way."""
        move = self._move
        if move is None:
            return
        self._steps += steps
        share = move.way_share(self._steps * STEP_S)
        self._set([start + share * (goal - start) for start, goal in zip(move.start, move.goal, strict=True)])
        if self._steps * STEP_S >= move.duration_s:
            self._move = None


class HeldLeg(Leg):
    """A leg that is exactly where its holder has it, or stands upright on what is below."""

    def __init__(self, engine: Engine, place: Vector) -> None:
        super().__init__(engine, place)
        self._carrier: Callable[[], Pose] | None = None
        self._frame: Pose = ((0.0, 0.0, 0.0), UPRIGHT)
        self._pull: Vector = (0.0, 0.0, 0.0)
        self._felt: Vector = (0.0, 0.0, 0.0)

    def grasp(self, torso: Torso) -> None:
        """Be held by the robot's palm as it stands."""
        self._be_carried(torso.palm_pose, Held.ROBOT)

    def torn(self) -> bool:
        """True while it is pulled at with more than the grasp holds."""
        return math.hypot(*self._felt) > GRASP_FORCE_N

    def take(self, hand: int) -> None:
        """Be held by a person's hand as it is, and by nothing else."""
        self._be_carried(lambda: self._engine.pose(hand), Held.PERSON)

    def drop(self) -> None:
        """Stand on what is below, at once."""
        x, y, _ = place = self.pose()[0]
        self._engine.place(self.body, ((x, y, height_below(place) + LEG_LENGTH_M / 2), UPRIGHT))
        self._carrier, self.held = None, Held.LOOSE

    def finish(self) -> None:
        """Let the leg stay where it is for good."""
        self._carrier, self.held = None, Held.DONE

    def pull(self, force_n: Vector) -> None:
        """Pull at the leg for one step."""
        finite("pull on the leg", force_n)
        self._pull = force_n

    def reaction(self) -> Vector:
        """What the robot's palm feels of the leg (N, world axes): its weight, and who pulls."""
        self._check_felt()
        x, y, z = self._felt
        return (x, y, z - LEG_MASS_KG * GRAVITY_M_S2)

    def speed(self) -> float:
        """0: nothing moves by itself."""
        return 0.0

    def advance(self, steps: int) -> None:
        """Follow the holder; `steps` do not matter."""
        self._felt, self._pull = self._pull, (0.0, 0.0, 0.0)
        if self._carrier is not None:
            self._engine.place(self.body, bullet.multiplyTransforms(*self._carrier(), *self._frame))

    def _be_carried(self, carrier: Callable[[], Pose], held: Held) -> None:
        self._frame = bullet.multiplyTransforms(*bullet.invertTransform(*carrier()), *self.pose())
        self._carrier, self.held = carrier, held
