"""PyBullet with checked arguments, and the time of physics.

PyBullet answers a wrong id with an empty result and a NaN with a NaN state. Either would let a requirement pass that
was never checked, so both are errors here. Physics advances in whole steps of 1/120 s (see docs/convergence.md), the
kernel in microseconds.
"""

from __future__ import annotations

import math
import os
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self


@contextmanager
def silenced() -> Iterator[None]:
    """Discard what C code prints on the process's output and error streams."""
    sys.stdout.flush()
    sys.stderr.flush()
    saved = os.dup(1), os.dup(2)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        yield
    finally:
        for number, stream in zip(saved, (1, 2), strict=True):
            os.dup2(number, stream)
            os.close(number)
        os.close(nowhere)


try:
    with silenced():  # its banner
        import pybullet
except ImportError as error:  # numpy missing counts too: PyBullet needs it without declaring it
    raise ImportError(
        f'the simulated world needs PyBullet and numpy ({error}): pip install "pytest-hricdv[sim]"'
    ) from error

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Pose = tuple[Vector, Quaternion]

UPRIGHT: Quaternion = (0.0, 0.0, 0.0, 1.0)
FAR_M = 10.0
"""Search distance for closest points: larger than the whole scene, so that there is always a pair."""

bullet: Any = pybullet
"""The PyBullet module; it has no types."""

STEP_HZ = 120
"""Physics steps per second: measured joint speeds equal the planned ones (tests/sim/test_robot.py)."""

STEP_S = 1.0 / STEP_HZ
TICK_HZ = 20
TICK_STEPS = STEP_HZ // TICK_HZ
"""Steps between two control ticks."""

_US_PER_S = 1_000_000


class SimulationError(Exception):
    """An impossible request to the world, or an error of physics; the message says what and when."""


def check_finite(what: str, values: Sequence[float]) -> None:
    """Raise SimulationError unless every one of `values` is a finite number."""
    for value in values:
        if not math.isfinite(value):
            raise SimulationError(f"{what} is {tuple(values)!r}: expected finite numbers")


class Engine:
    """One PyBullet client without a window, with gravity and a solver that keeps planned speeds.

    Fixed time step `step_s`. Dantzig's direct LCP solver instead of the default iterative one: the latter read 0.2625
    rad/s for a 0.24 rad/s motor (tests/sim/test_robot.py measures the speeds), and is slower here.
    """

    def __init__(self, step_s: float) -> None:
        self._link_counts: dict[int, int] = {}
        with silenced():
            self.client: int = bullet.connect(bullet.DIRECT)
            if self.client < 0:
                raise SimulationError("PyBullet gave no client")
            bullet.setPhysicsEngineParameter(
                fixedTimeStep=step_s,
                numSubSteps=0,
                constraintSolverType=bullet.CONSTRAINT_SOLVER_LCP_DANTZIG,
                physicsClientId=self.client,
            )
            bullet.setGravity(0.0, 0.0, -9.81, physicsClientId=self.client)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Disconnect the client; may be called more than once."""
        if self.client >= 0:
            bullet.disconnect(self.client)
            self.client = -1

    def load(
        self, description: str, *, may_sleep: bool, merge_links: bool = False
    ) -> tuple[int, dict[str, int], dict[str, tuple[float, float]]]:
        """Load a robot with a fixed base from URDF text.

        Args:
            description: the text.
            may_sleep: the body can be put to sleep, and falls asleep by itself unless it is kept awake.
            merge_links: rigidly joined links are merged, which leaks their memory (see `sim.urdf`).

        Returns:
            Its body id; joint name without "_joint" -> index; joint name -> limits (rad).
        """
        flags = bullet.URDF_USE_INERTIA_FROM_FILE | (bullet.URDF_MERGE_FIXED_LINKS if merge_links else 0)
        flags |= bullet.URDF_ENABLE_SLEEPING if may_sleep else 0
        with (
            tempfile.NamedTemporaryFile("w", suffix=".urdf", encoding="utf-8") as file,
            silenced(),
        ):  # PyBullet wants a file
            file.write(description)
            file.flush()
            try:
                body: int = bullet.loadURDF(file.name, useFixedBase=True, flags=flags, physicsClientId=self.client)
            except bullet.error as error:
                raise SimulationError(f"PyBullet refused the robot description {description[:80]!r}...") from error
        count = bullet.getNumJoints(body, physicsClientId=self.client)
        self._link_counts[body] = count
        infos = [bullet.getJointInfo(body, index, physicsClientId=self.client) for index in range(count)]
        names = [info[1].decode().removesuffix("_joint") for info in infos]
        limits = {name: (info[8], info[9]) for name, info in zip(names, infos, strict=True)}
        return body, {name: index for index, name in enumerate(names)}, limits

    def set_collision_group(self, body: int, group: int, by: int) -> None:
        """Put all links of a body into a collision group that collides with the groups `by`; switch damping off."""
        self.check(body)
        for link in range(-1, self._link_counts[body]):
            bullet.setCollisionFilterGroupMask(body, link, group, by, physicsClientId=self.client)
            bullet.changeDynamics(body, link, linearDamping=0.0, angularDamping=0.0, physicsClientId=self.client)

    def add(self, mass_kg: float, position: Vector, rgba: Sequence[float], **shape: Any) -> int:
        """Add a body of one primitive shape (keyword arguments of PyBullet's createCollisionShape).

        Physics never moves a body of mass 0. Returns its body id.
        """
        check_finite("mass and position of a body", (mass_kg, *position))
        seen = {"length" if name == "height" else name: value for name, value in shape.items()}
        collision = bullet.createCollisionShape(physicsClientId=self.client, **shape)
        visual = bullet.createVisualShape(rgbaColor=rgba, physicsClientId=self.client, **seen)
        body: int = bullet.createMultiBody(mass_kg, collision, visual, position, physicsClientId=self.client)
        if body < 0:
            raise SimulationError(f"PyBullet refused a body of shape {shape!r}")
        self._link_counts[body] = 0
        return body

    def remove(self, body: int) -> None:
        """Remove a body."""
        self.check(body)
        bullet.removeBody(body, physicsClientId=self.client)
        del self._link_counts[body]

    def check(self, body: int, link: int = -1) -> None:
        """Raise SimulationError unless `body` is one of this engine and has that link (-1 is its base)."""
        if body not in self._link_counts or not -1 <= link < self._link_counts[body]:
            raise SimulationError(f"no link {link!r} of body {body!r}; bodies and their links: {self._link_counts}")

    def pose(self, body: int) -> Pose:
        """Position (m) and orientation of a body's centre of mass."""
        self.check(body)
        pose: Pose = bullet.getBasePositionAndOrientation(body, physicsClientId=self.client)
        return pose

    def place(self, body: int, pose: Pose) -> None:
        """Set the pose of a body."""
        self.check(body)
        check_finite(f"pose of body {body}", (*pose[0], *pose[1]))
        bullet.resetBasePositionAndOrientation(body, pose[0], pose[1], physicsClientId=self.client)

    def distance(self, body: int, other: int, other_link: int) -> float:
        """Smallest distance (m) between a body's base and a link of another; negative when they overlap."""
        self.check(body)
        self.check(other, other_link)
        return _nearest(
            bullet.getClosestPoints(body, other, FAR_M, -1, other_link, physicsClientId=self.client), body, other
        )

    def distance_to_all(self, body: int, other: int) -> float:
        """Smallest distance (m) between any links of two bodies; negative when they overlap."""
        self.check(body)
        self.check(other)
        return _nearest(bullet.getClosestPoints(body, other, FAR_M, physicsClientId=self.client), body, other)


def _nearest(points: Sequence[tuple[Any, ...]], body: int, other: int) -> float:
    if not points:
        raise SimulationError(f"bodies {body} and {other} have no closest points")
    return float(min([point[8] for point in points]))


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
        return self.step + max(1, -int(-duration_s * STEP_HZ // 1))
