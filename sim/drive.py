"""What moves joints: motors that physics drives. The small interface between a robot's parts and its joints."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Protocol

from sim.engine import Engine, SimulationError, bullet, finite

POSITION_GAIN = 0.3
VELOCITY_GAIN = 1.0
"""Motor settings whose measured speed is the planned one with one call a joint and move (tests/sim/test_robot.py)."""

HOLD_SPEED_RAD_S = 0.02
"""Top speed of a joint that is to stay where it is: it may correct itself, and slowly."""


class Drive(Protocol):
    """Some joints of a body that move together."""

    def move(self, goal: Sequence[float], duration_s: float) -> None:
        """Start towards `goal` (rad), all joints to arrive after `duration_s`."""

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
        speeds = [abs(state[1]) for state in states]
        if not math.isfinite(sum(speeds)):
            raise SimulationError(f"joint speeds of the robot are {speeds!r}: expected finite numbers")
        return float(max(speeds))

    def _set(self, pose: Sequence[float]) -> None:
        for index, angle in zip(self._indices, pose, strict=True):
            bullet.resetJointState(self._body, index, angle, 0.0, physicsClientId=self._client)


class MotorDrive(Joints):
    """A `Drive` of position motors with a torque limit each: one command a joint and move, the rest is physics.

    Streaming positions instead would make an arm faster than planned (0.385 rad/s for a plan of 0.24).
    """

    def __init__(self, engine: Engine, body: int, indices: Sequence[int], torques_nm: Sequence[float]) -> None:
        super().__init__(engine, body, indices)
        self._torques_nm = tuple(torques_nm)

    def move(self, goal: Sequence[float], duration_s: float) -> None:
        """See `Drive`. Raises SimulationError for a goal or a duration that is not finite, or no positive duration."""
        finite("goal and duration of a move", (*goal, duration_s))
        if duration_s <= 0.0:
            raise SimulationError(f"duration of a move is {duration_s!r} s: expected more than 0")
        ways = [abs(g - a) for g, a in zip(goal, self.angles(), strict=True)]
        self._command(goal, [max(way / duration_s, HOLD_SPEED_RAD_S) for way in ways])

    def put(self, pose: Sequence[float]) -> None:
        """See `Drive`."""
        finite("pose", pose)
        self._set(pose)
        self._command(pose, [HOLD_SPEED_RAD_S] * len(self._indices))

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
