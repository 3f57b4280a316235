"""What the simulated world needs of a physics engine, and the time of physics.

`Engine` is the seam: beside a folder of an engine, nothing in `sim` knows which one it is. Physics advances in whole
steps of 1/120 s (see docs/studies/convergence.md), the kernel in microseconds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import NamedTuple, Protocol, Self

from sim.geometry import Pose, Quaternion, Vector
from sim.shapes import Shape, Surface, Visual

STEP_HZ = 120
"""Physics steps per second: measured joint speeds equal the planned ones (tests/sim/test_robot.py)."""

STEP_S = 1.0 / STEP_HZ
TICK_HZ = 20  # the case study's code polls every 50 ms
TICK_STEPS = STEP_HZ // TICK_HZ
"""Steps between two control ticks."""

_US_PER_S = 1_000_000


class SimulationError(Exception):
    """An impossible request to the world, or an error of physics; the message says what and when."""


def check_finite(subject: str, values: Sequence[float]) -> None:
    """Raise SimulationError unless every one of `values` is a finite number."""
    if not all(map(math.isfinite, values)):
        raise SimulationError(f"{subject} is {tuple(values)!r}: expected finite numbers")


class Robot(NamedTuple):
    """A robot with a fixed base.

    Args:
        body: its id.
        joints: name of a joint without "_joint" -> its number, which is that of the link it moves.
        limits_rad: name -> its limits.
    """

    body: int
    joints: dict[str, int]
    limits_rad: dict[str, tuple[float, float]]


class Contact(NamedTuple):
    """Where one body is deepest in another: depth (m, negative when apart), place (m), direction out of the other."""

    depth_m: float
    place: Vector
    away: Vector


class Drive(Protocol):
    """Some joints of a body that move together."""

    def move(self, goal: Sequence[float], duration_s: float, ramp_s: float = 0.0) -> None:
        """Start towards `goal` (rad), all joints to arrive after `duration_s`.

        They accelerate during `ramp_s` and decelerate during the same time. Raises SimulationError for a number that is
        not finite, a duration that is not positive, or ramps that are too long for it.
        """

    def stop(self) -> None:
        """Brake, and hold the present angles."""

    def reset(self, pose: Sequence[float]) -> None:
        """Set the joints to `pose` (rad) at once, and hold it."""

    def angles(self) -> tuple[float, ...]:
        """Joint angles (rad)."""

    def speed(self) -> float:
        """Speed of the fastest joint (rad/s)."""

    def speeds(self) -> Sequence[float]:
        """The same after each step of the last advance, in the order of time; the last one is that of now."""


class Engine(Protocol):
    """One scene of a physics engine, with gravity and a fixed time step.

    Engines answer a wrong id with an empty result and a NaN with a NaN state. Either would let a requirement pass that
    was never checked: all methods raise SimulationError instead. Link -1 of a body is its base.
    """

    def __enter__(self) -> Self: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None
    ) -> None: ...

    def close(self) -> None:
        """Release all resources; may be called more than once."""

    def advance(self, steps: int) -> int:
        """Advance by time steps, with all drives: at least one, at most `steps`. Returns how many were made.

        There are fewer when something begins that depends on each step, such as a weld that gives way. Forces that were
        applied last during all of them.
        """

    # bodies

    def load(self, description: str, *, may_sleep: bool = False) -> Robot:
        """Load a robot with a fixed base, without drag of the air, from URDF text.

        Args:
            description: the text; links without visual shapes.
            may_sleep: the robot can be put to sleep (`sleep`).
        """

    def add(self, mass_kg: float, position: Vector, rgba: Sequence[float], shape: Shape) -> int:
        """Add a body of one shape; physics never moves a body of mass 0. Returns its id."""

    def remove(self, body: int) -> None:
        """Remove a body."""

    def check(self, body: int, link: int = -1) -> None:
        """Raise SimulationError unless there is such a body and it has that link."""

    def set_collision_group(self, body: int, group: int, by: int) -> None:
        """Put all links of a body into a collision group that collides with the groups `by`."""

    def set_surface(self, body: int, surface: Surface) -> None:
        """Give a body of one shape this surface."""

    def sleep(self, body: int, asleep: bool) -> None:
        """Put a robot that may sleep to sleep, which costs no computing time, or keep it awake."""

    # where they are

    def pose(self, body: int) -> Pose:
        """Position (m) and orientation of a body's centre of mass."""

    def place(self, body: int, pose: Pose) -> None:
        """Set the pose of a body."""

    def body_speed(self, body: int) -> float:
        """Speed (m/s) of a body's centre of mass."""

    def link_frame(self, body: int, link: int) -> Pose:
        """Position (m) and orientation of a link's frame."""

    def link_mass_frame(self, body: int, link: int) -> Pose:
        """Pose of a link's centre of mass: what joints between bodies are relative to."""

    def compose(self, base: Pose, pose: Pose) -> Pose:
        """The pose that is `pose` relative to `base`; engines differ in precision."""

    def relative(self, base: Pose, pose: Pose) -> Pose:
        """A pose relative to `base`: the reverse of `compose`."""

    def between(self, start: Quaternion, other: Quaternion, share: float) -> Quaternion:
        """The orientation that is this share of the way from one to another (spherical linear interpolation)."""

    def visuals(self, described: Mapping[int, str]) -> dict[Visual, Pose]:
        """All shapes that are seen, and where they are.

        Args:
            described: body -> URDF text with its visual shapes, for robots that were loaded without.
        """

    # how near they are

    def distance(self, body: int, other: int, other_link: int) -> float:
        """Smallest distance (m) between a body's base and a link of another; negative when they overlap."""

    def distance_to_all(self, body: int, other: int) -> float:
        """Smallest distance (m) between any links of two bodies; negative when they overlap."""

    def deepest(self, body: int, link: int, other: int) -> Contact:
        """Where a link is deepest in, or nearest to, the base of another body."""

    def near(self, body: int, other: int, within_m: float, *links: int) -> list[tuple[int, float]]:
        """The links of a body that are nearer to another body than this, each with its distance (m).

        Args:
            body: the body.
            other: the other one.
            within_m: how near.
            links: a link of each, where only these matter.
        """

    # how they move

    def joint_angles(self, body: int, joints: Sequence[int]) -> tuple[float, ...]:
        """Angles (rad)."""

    def joint_speeds(self, body: int, joints: Sequence[int]) -> list[float]:
        """Speeds (rad/s)."""

    def set_joints(self, body: int, joints: Sequence[int], angles: Sequence[float]) -> None:
        """Set angles (rad) at once; the joints stand."""

    def drive(self, body: int, joints: Sequence[int], torques_nm: Sequence[float]) -> Drive:
        """Motors of these maximum torques (Nm) that move joints as planned; each keeps its joint where it is."""

    def push(self, body: int, link: int, force_n: Vector, place: Vector) -> None:
        """Push for one step: force (N) at a place (m), both in world axes."""

    def push_link(self, body: int, link: int, force_n: Vector, place: Vector) -> None:
        """The same in the axes of the link, from its centre of mass."""

    def weld(self, body: int, link: int, other: int, frame: Pose, force_n: float) -> int:
        """Weld a body to a link of another so that its pose relative to that link's centre of mass is `frame`.

        Beyond a force (N) the weld gives way. Returns its id.
        """

    def set_weld_force(self, weld: int, force_n: float) -> None:
        """Beyond this force (N) the weld gives way from now on."""

    def weld_force(self, weld: int) -> Vector:
        """The force (N, world axes) with which the weld holds the body."""

    def unweld(self, weld: int) -> None:
        """Remove a weld."""


def steps_until(time_us: int) -> int:
    """Number of whole steps up to a time (us), in integers so that nothing drifts."""
    return time_us * STEP_HZ // _US_PER_S


def time_of(step: int) -> int:
    """First whole microsecond at or after the end of a step."""
    return -(-step * _US_PER_S // STEP_HZ)


@dataclass
class PhysicsTime:
    """`step`: physics steps computed or skipped so far. `now_us`: simulated time (us)."""

    step: int = 0
    now_us: int = 0

    @property
    def now_s(self) -> float:
        """Simulated time, in seconds."""
        return self.now_us / 1_000_000

    def step_in(self, duration_s: float) -> int:
        """The first step that ends at least `duration_s` from now."""
        return self.step + max(1, -int(-duration_s * STEP_HZ // 1))  # -int(-x // 1) rounds up
