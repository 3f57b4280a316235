"""Joints that are driven: their angles and speeds, and straight moves of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from sim.engine import Drive, Engine, SimulationError, check_finite

DriveMaker = Callable[[Engine, int, Sequence[int], Sequence[float]], Drive]
"""Creates a drive from an engine, a body, the numbers of its joints, and their maximum torques (Nm)."""


def motors(engine: Engine, body: int, joints: Sequence[int], torques_nm: Sequence[float]) -> Drive:
    """The engine's motors."""
    return engine.drive(body, joints, torques_nm)


class Joints:
    """Angles and speeds of some joints of a body, read from the engine."""

    def __init__(self, engine: Engine, body: int, joints: Sequence[int]) -> None:
        for joint in joints:
            engine.check(body, joint)
        self._engine = engine
        self._body = body
        self._joints = tuple(joints)

    def angles(self) -> tuple[float, ...]:
        """Joint angles (rad)."""
        return self._engine.joint_angles(self._body, self._joints)

    def speed(self) -> float:
        """Speed of the fastest joint (rad/s). Raises SimulationError when any is not finite."""
        speeds = self._engine.joint_speeds(self._body, self._joints)
        return float(max(max(speeds), -min(speeds))) + 0.0

    def speeds(self) -> Sequence[float]:
        """See `Drive`: of an engine that makes one step at a time."""
        return (self.speed(),)

    def _set(self, pose: Sequence[float]) -> None:
        self._engine.set_joints(self._body, self._joints, pose)


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
