"""Rigid transforms and their interpolation over time, for `frame_tree` and `tf2`.

A `Transform` is a rotation and a translation. The transforms of a frame over time are a `MovingFrame`, which
interpolates, or a `StaticFrame`. Quaternions are (x, y, z, w), as in messages. Formulas and their order are those of
tf2's `LinearMath`, so that results agree to the last digits.
"""

from __future__ import annotations

import bisect
import math
from dataclasses import dataclass, field

Vector = tuple[float, float, float]  # x, y, z
Quaternion = tuple[float, float, float, float]  # x, y, z, w

IDENTITY: Quaternion = (0.0, 0.0, 0.0, 1.0)
NO_TRANSLATION: Vector = (0.0, 0.0, 0.0)


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """The rotation by `b`, then by `a`."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by + ay * bw + az * bx - ax * bz,
        aw * bz + az * bw + ax * by - ay * bx,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def inverse(q: Quaternion) -> Quaternion:
    """The inverse rotation of a quaternion of length 1."""
    return (-q[0], -q[1], -q[2], q[3])


def rotate(q: Quaternion, v: Vector) -> Vector:
    """A vector, rotated."""
    x, y, z, _ = product(product(q, (*v, 0.0)), inverse(q))
    return (x, y, z)


def add(a: Vector, b: Vector) -> Vector:
    """The sum of two vectors."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def negate(v: Vector) -> Vector:
    """The vector in the opposite direction."""
    return (-v[0], -v[1], -v[2])


def slerp(a: Quaternion, b: Quaternion, share: float) -> Quaternion:
    """The rotation between `a` (share 0) and `b` (share 1) on the shorter arc (Shoemake 1985)."""
    dot = sum(x * y for x, y in zip(a, b, strict=True))
    length = math.sqrt(sum(x * x for x in a) * sum(x * x for x in b))
    theta = math.acos(max(-1.0, min(1.0, abs(dot) / length)))
    if theta == 0.0:
        return a
    of_a, of_b = math.sin((1.0 - share) * theta), math.sin(share * theta) * (-1.0 if dot < 0 else 1.0)
    x, y, z, w = ((p * of_a + q * of_b) / math.sin(theta) for p, q in zip(a, b, strict=True))
    return (x, y, z, w)


@dataclass(frozen=True)
class Transform:
    """A transform from a child frame to its parent, or from a source frame to a target frame."""

    translation: Vector = NO_TRANSLATION
    rotation: Quaternion = IDENTITY

    def of(self, point: Vector) -> Vector:
        """A point of the child frame, in the parent frame."""
        return add(rotate(self.rotation, point), self.translation)

    def after(self, first: Transform) -> Transform:
        """The composition of both, `first` first."""
        return Transform(self.of(first.translation), product(self.rotation, first.rotation))

    def inverse(self) -> Transform:
        """The way back."""
        back = inverse(self.rotation)
        return Transform(rotate(back, negate(self.translation)), back)


@dataclass(frozen=True)
class StampedTransform(Transform):
    """The buffered transform of a frame, relative to its parent frame, at a time."""

    stamp_ns: int = 0
    parent: str = ""


class NoTransformError(LookupError):
    """There is no transform for this time; `kind` says on which side: "past", "future" or "only one"."""

    def __init__(self, kind: str, text: str) -> None:
        super().__init__(text)
        self.kind = kind


def seconds(time_ns: int) -> str:
    """A time as tf2 shows it."""
    return f"{time_ns / 1e9:.6f}"


@dataclass
class StaticFrame:
    """A frame that does not move."""

    stored: StampedTransform | None = None
    is_static = True
    latest_ns = oldest_ns = 0

    def __len__(self) -> int:
        return 1

    def insert(self, stored: StampedTransform) -> bool:
        """Take this one for all times."""
        self.stored = stored
        return True

    def at(self, time_ns: int) -> StampedTransform:
        """The static transform, for any time."""
        assert self.stored is not None
        return StampedTransform(self.stored.translation, self.stored.rotation, time_ns, self.stored.parent)

    @property
    def parent(self) -> str:
        """The frame that it is relative to."""
        return "" if self.stored is None else self.stored.parent

    def clear(self) -> None:
        """Clear the buffer, except static transforms."""


@dataclass
class MovingFrame:
    """The transforms of a frame over time, the oldest first; those of `keeps_ns` before the latest one are kept."""

    keeps_ns: int
    _stored: list[StampedTransform] = field(default_factory=list)
    is_static = False

    def __len__(self) -> int:
        return len(self._stored)

    @property
    def latest_ns(self) -> int:
        """The time of the latest; 0 without any."""
        return self._stored[-1].stamp_ns if self._stored else 0

    @property
    def oldest_ns(self) -> int:
        """The time of the oldest; 0 without any."""
        return self._stored[0].stamp_ns if self._stored else 0

    @property
    def parent(self) -> str:
        """The frame that the latest is relative to; empty without any."""
        return self._stored[-1].parent if self._stored else ""

    def clear(self) -> None:
        """Forget all."""
        self._stored.clear()

    def insert(self, stored: StampedTransform) -> bool:
        """Add one, and forget those too old compared with the latest; False if it is too old itself."""
        latest_ns = self.latest_ns
        while self._stored and self._stored[0].stamp_ns + self.keeps_ns < latest_ns:
            del self._stored[0]
        if self._stored and stored.stamp_ns < latest_ns - self.keeps_ns:
            return False
        place = bisect.bisect_right(self._stored, stored.stamp_ns, key=lambda other: other.stamp_ns)
        same = [other for other in self._stored[:place] if other.stamp_ns == stored.stamp_ns]
        if stored not in same:
            self._stored.insert(place, stored)
        return True

    def at(self, time_ns: int) -> StampedTransform:
        """The transform at a time, interpolated between its neighbours; 0 means the latest.

        Raises:
            NoTransformError: the time is before the first or after the last.
        """
        if self._stored and time_ns == 0:
            return self._stored[-1]
        if len(self._stored) < 2 and (not self._stored or self._stored[0].stamp_ns != time_ns):
            text = f"extrapolation at time {seconds(time_ns)}, but only time {seconds(self.latest_ns)} is in the buffer"
            raise NoTransformError("only one", f"Lookup would require {text}")
        for stored in (self._stored[-1], self._stored[0]):
            if time_ns == stored.stamp_ns:
                return stored
        for kind, is_beyond, which, end_ns in (
            ("future", time_ns > self.latest_ns, "latest", self.latest_ns),
            ("past", time_ns < self.oldest_ns, "earliest", self.oldest_ns),
        ):
            if is_beyond:
                raise NoTransformError(
                    kind,
                    f"Lookup would require extrapolation into the {kind}.  Requested time {seconds(time_ns)} "
                    f"but the {which} data is at time {seconds(end_ns)}",
                )
        place = bisect.bisect_right(self._stored, time_ns, key=lambda other: other.stamp_ns)
        return _between(self._stored[place - 1], self._stored[place], time_ns)


def _between(older: StampedTransform, newer: StampedTransform, time_ns: int) -> StampedTransform:
    if older.parent != newer.parent:
        return older
    share = (time_ns - older.stamp_ns) / (newer.stamp_ns - older.stamp_ns)
    x, y, z = ((1.0 - share) * a + share * b for a, b in zip(older.translation, newer.translation, strict=True))
    return StampedTransform((x, y, z), slerp(older.rotation, newer.rotation, share), older.stamp_ns, older.parent)
