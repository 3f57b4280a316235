"""What moves joints: motors that physics drives. The small interface between a robot's parts and its joints."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from sim.engine import Engine, SimulationError, bullet, finite
from sim.physics_time import STEP_S

POSITION_GAIN = 0.3
VELOCITY_GAIN = 1.0
"""Motor settings whose measured speed is the planned one with one call a joint and move (tests/sim/test_robot.py)."""

HOLD_SPEED_RAD_S = 0.02
"""Top speed of a joint that is to stay where it is: it may correct itself, and slowly."""


class Drive(Protocol):
    """Some joints of a body that move together."""

    def move(self, goal: Sequence[float], duration_s: float, ramp_s: float = 0.0) -> None:
        """Start towards `goal` (rad), all joints to arrive after `duration_s`.

        They speed up evenly in `ramp_s`, and slow down in as much. Raises SimulationError for a number that is not
        finite, no positive duration, or ramps that do not fit into it.
        """

    def advance(self, steps: int) -> None:
        """Called before physics steps."""

    def put(self, pose: Sequence[float]) -> None:
        """Be at `pose` (rad) at once, and stay there."""

    def angles(self) -> tuple[float, ...]:
        """Joint angles (rad)."""

    def speed(self) -> float:
        """Speed of the fastest joint (rad/s)."""


DriveMaker = Callable[[Engine, int, Sequence[int], Sequence[float]], Drive]
"""Makes a drive of an engine's body, its joints' indices, and their strongest torques (Nm)."""


class Joints:
    """Angles and speeds of some joints of a body, read from the engine."""

    def __init__(self, engine: Engine, body: int, indices: Sequence[int]) -> None:
        for index in indices:
            engine.check(body, index)
        self._client = engine.client
        self._body = body
        self._indices = tuple(indices)

    def angles(self) -> tuple[float, ...]:
        """Joint angles (rad)."""
        states = bullet.getJointStates(self._body, self._indices, physicsClientId=self._client)
        return tuple([state[0] for state in states])

    def speed(self) -> float:
        """Speed of the fastest joint (rad/s). Raises SimulationError when any is not finite."""
        states = bullet.getJointStates(self._body, self._indices, physicsClientId=self._client)
        speeds = [state[1] for state in states]
        if not math.isfinite(sum(speeds)):
            raise SimulationError(f"joint speeds of the robot are {speeds!r}: expected finite numbers")
        return float(max(max(speeds), -min(speeds))) + 0.0

    def _set(self, pose: Sequence[float]) -> None:
        for index, angle in zip(self._indices, pose, strict=True):
            bullet.resetJointState(self._body, index, angle, 0.0, physicsClientId=self._client)


@dataclass(frozen=True)
class Move:
    """A straight move from rest to rest, its speed a trapezoid over time; joint angles in rad."""

    start: tuple[float, ...]
    goal: tuple[float, ...]
    duration_s: float
    ramp_s: float

    def __post_init__(self) -> None:
        finite("goal, duration and ramps of a move", (*self.goal, self.duration_s, self.ramp_s))
        if self.duration_s <= 0.0:
            raise SimulationError(f"duration of a move is {self.duration_s!r} s: expected more than 0")
        if not 0.0 <= self.ramp_s <= 0.5 * self.duration_s * (1.0 + 1e-9):
            raise SimulationError(f"ramps of {self.ramp_s!r} s do not fit into a move of {self.duration_s!r} s")

    @property
    def top_speeds_rad_s(self) -> tuple[float, ...]:
        """Each joint's speed between the ramps."""
        cruise_s = self.duration_s - self.ramp_s
        return tuple([abs(goal - start) / cruise_s for start, goal in zip(self.start, self.goal, strict=True)])

    def speed_share(self, time_s: float) -> float:
        """Share of the top speed at a time after the start."""
        if self.ramp_s == 0.0:
            return 1.0 if 0.0 <= time_s <= self.duration_s else 0.0
        return max(0.0, min(1.0, time_s / self.ramp_s, (self.duration_s - time_s) / self.ramp_s))

    def way_share(self, time_s: float) -> float:
        """Share of the way that is done at a time after the start: the integral of the speed."""
        time_s = min(max(time_s, 0.0), self.duration_s)
        left_s = self.duration_s - time_s
        if time_s < self.ramp_s:
            done_s = 0.5 * time_s * time_s / self.ramp_s
        elif left_s < self.ramp_s:
            done_s = self.duration_s - self.ramp_s - 0.5 * left_s * left_s / self.ramp_s
        else:
            done_s = time_s - 0.5 * self.ramp_s
        return done_s / (self.duration_s - self.ramp_s)


class MotorDrive(Joints):
    """A `Drive` of position motors with a torque limit each: they are sent to the goal once, and physics does the rest.

    Streaming positions instead would make an arm faster than planned (0.385 rad/s for a plan of 0.24). What changes
    along a ramp is the motor's speed limit only, so that no joint is ever faster than planned.
    """

    def __init__(self, engine: Engine, body: int, indices: Sequence[int], torques_nm: Sequence[float]) -> None:
        super().__init__(engine, body, indices)
        self._torques_nm = tuple(torques_nm)
        self._move: Move | None = None  # with ramps, and not over
        self._steps = 0
        self._share = 0.0
        self._brakes_s = 0.0  # up to here the speed is at its top, once it is there

    def move(self, goal: Sequence[float], duration_s: float, ramp_s: float = 0.0) -> None:
        """See `Drive`."""
        move = Move(self.angles(), tuple(goal), duration_s, ramp_s)
        if ramp_s > 0.0:
            self._move, self._steps, self._share = move, 0, 0.0
            self._brakes_s = duration_s - ramp_s - STEP_S
        else:
            self._move = None
            self._command(goal, [max(speed, HOLD_SPEED_RAD_S) for speed in move.top_speeds_rad_s])

    def put(self, pose: Sequence[float]) -> None:
        """See `Drive`."""
        finite("pose", pose)
        self._move = None
        self._set(pose)
        self._command(pose, [HOLD_SPEED_RAD_S] * len(self._indices))

    def advance(self, steps: int) -> None:
        """See `Drive`: sets the speed limits of the next step, where they change."""
        move = self._move
        if move is None:
            return
        time_s = (self._steps + 0.5) * STEP_S
        self._steps += steps
        if self._share == 1.0 and time_s < self._brakes_s:  # most steps: nothing changes
            return
        over = time_s >= move.duration_s
        share = move.speed_share(time_s)
        if share != self._share:
            # Slowing down, what is left for the position control to do may be done at the speed of holding.
            least = 0.0 if share > self._share else HOLD_SPEED_RAD_S
            self._share = share
            self._command(move.goal, [max(share * speed, least) for speed in move.top_speeds_rad_s])
        if over:
            self._move = None

    def _command(self, goal: Sequence[float], top_speeds_rad_s: Sequence[float]) -> None:
        joints = zip(self._indices, goal, self._torques_nm, top_speeds_rad_s, strict=True)
        for index, angle, torque_nm, top_speed_rad_s in joints:
            bullet.setJointMotorControl2(
                self._body,
                index,
                bullet.POSITION_CONTROL,
                angle,
                force=torque_nm,
                positionGain=POSITION_GAIN,
                velocityGain=VELOCITY_GAIN,
                maxVelocity=top_speed_rad_s,
                physicsClientId=self._client,
            )
