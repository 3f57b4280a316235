"""Drives that move joints: the interface, and position motors in the physics engine."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from sim.engine import STEP_S, Engine, SimulationError, bullet, check_finite

POSITION_GAIN = 0.3
VELOCITY_GAIN = 1.0
"""Gains with which joints have the planned speed, with one command per joint and move (tests/sim/test_robot.py)."""

HOLD_SPEED_RAD_S = 0.02
"""Top speed of a joint that holds its position: corrections are slow."""


class Drive(Protocol):
    """Some joints of a body that move together."""

    def move(self, goal: Sequence[float], duration_s: float, ramp_s: float = 0.0) -> None:
        """Start towards `goal` (rad), all joints to arrive after `duration_s`.

        They accelerate during `ramp_s` and decelerate during the same time. Raises SimulationError for a number that is
        not finite, a duration that is not positive, or ramps that are too long for it.
        """

    def advance(self, steps: int) -> None:
        """Called before physics steps."""

    def stop(self) -> None:
        """Brake, and hold the present angles."""

    def reset(self, pose: Sequence[float]) -> None:
        """Set the joints to `pose` (rad) at once, and hold it."""

    def angles(self) -> tuple[float, ...]:
        """Joint angles (rad)."""

    def speed(self) -> float:
        """Speed of the fastest joint (rad/s)."""


DriveMaker = Callable[[Engine, int, Sequence[int], Sequence[float]], Drive]
"""Creates a drive from an engine, a body, the indices of its joints, and their maximum torques (Nm)."""


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

    def _reset_joints(self, pose: Sequence[float]) -> None:
        for index, angle in zip(self._indices, pose, strict=True):
            bullet.resetJointState(self._body, index, angle, 0.0, physicsClientId=self._client)


@dataclass(frozen=True)
class Move:
    """A straight move from rest to rest with a trapezoidal speed profile; joint angles in rad."""

    start: tuple[float, ...]
    goal: tuple[float, ...]
    duration_s: float
    ramp_s: float

    def __post_init__(self) -> None:
        check_finite("goal, duration and ramps of a move", (*self.goal, self.duration_s, self.ramp_s))
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

    def distance_share(self, time_s: float) -> float:
        """Share of the distance covered at a time after the start: the integral of the speed."""
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
    """A `Drive` of position motors with torque limits: each motor is sent to the goal once.

    Streaming positions instead would make the arm faster than planned (0.385 rad/s for a plan of 0.24). Along a ramp
    only the motor's speed limit changes, so that no joint is ever faster than planned.
    """

    def __init__(self, engine: Engine, body: int, indices: Sequence[int], torques_nm: Sequence[float]) -> None:
        super().__init__(engine, body, indices)
        self._torques_nm = tuple(torques_nm)
        self._move: Move | None = None  # an unfinished move with ramps
        self._steps = 0
        self._share = 0.0
        self._cruise_end_s = 0.0  # end of the time at top speed

    def move(self, goal: Sequence[float], duration_s: float, ramp_s: float = 0.0) -> None:
        """See `Drive`."""
        move = Move(self.angles(), tuple(goal), duration_s, ramp_s)
        if ramp_s > 0.0:
            self._move, self._steps, self._share = move, 0, 0.0
            self._cruise_end_s = duration_s - ramp_s - STEP_S
        else:
            self._move = None
            self._command(goal, [max(speed, HOLD_SPEED_RAD_S) for speed in move.top_speeds_rad_s])

    def stop(self) -> None:
        """See `Drive`."""
        self._move = None
        self._command(self.angles(), [HOLD_SPEED_RAD_S] * len(self._indices))

    def reset(self, pose: Sequence[float]) -> None:
        """See `Drive`."""
        check_finite("pose", pose)
        self._move = None
        self._reset_joints(pose)
        self._command(pose, [HOLD_SPEED_RAD_S] * len(self._indices))

    def advance(self, steps: int) -> None:
        """See `Drive`: sets the speed limits for the next step if they change."""
        move = self._move
        if move is None:
            return
        time_s = (self._steps + 0.5) * STEP_S
        self._steps += steps
        if self._share == 1.0 and time_s < self._cruise_end_s:  # most steps: nothing changes
            return
        over = time_s >= move.duration_s
        share = move.speed_share(time_s)
        if share != self._share:
            # When slowing down, position control may correct the rest at the holding speed.
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
