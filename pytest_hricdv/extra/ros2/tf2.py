"""In the place of `tf2_py`, the C++ part of tf2, where it is not installed: `tf2_ros` for Python runs on it.

Names, messages of errors and results are those of tf2's `BufferCore`; its own tests in Python are run on this one.
"""

from __future__ import annotations

import importlib
import importlib.util
import math
import sys
from collections.abc import Iterator
from contextlib import suppress
from types import ModuleType
from typing import Any

from pytest_hricdv.extra.ros2.frame_tree import EXCEPTIONS, FrameTree
from pytest_hricdv.extra.ros2.transforms import (
    NO_WAY,
    StampedTransform,
    Transform,
    Vector,
    add,
    cross,
    inverse,
    negate,
    product,
    rotate,
    seconds,
)

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

NAME = "tf2_py"
_CACHE_NS = 10 * 10**9
"""As `tf2::BUFFER_CORE_DEFAULT_CACHE_TIME`."""
_TOLERANCE = 10e-3
"""How far the squared length of a quaternion may be from 1, as `QUATERNION_NORMALIZATION_TOLERANCE` of tf2."""


def _ns(time: Any) -> int:
    """Of a time or duration, of messages or of `rclpy`. Raises TypeError for anything else."""
    if hasattr(time, "sec") and hasattr(time, "nanosec"):
        return int(time.sec) * 10**9 + int(time.nanosec)
    if hasattr(time, "nanoseconds"):
        return int(time.nanoseconds)
    raise TypeError("time must have sec and nanosec, or nanoseconds.")


class BufferCore:
    """As `tf2_py.BufferCore`: the tree of frames, each with what is known of it in the course of time.

    Args:
        cache_time: how long transforms are kept, as a duration; 10 s by default.
    """

    def __init__(self, cache_time: Any = None) -> None:
        with suppress(ImportError):  # as the extension: who uses it finds these in `rclpy`, where that can be loaded
            importlib.import_module("rclpy.time")
            importlib.import_module("rclpy.duration")
        self._tree = FrameTree(_CACHE_NS if cache_time is None else _ns(cache_time))

    def clear(self) -> None:
        """Forget all transforms but static ones; names of frames stay."""
        self._tree.clear()

    def set_transform(self, transform: Any, authority: str) -> None:
        """Add a `geometry_msgs/msg/TransformStamped`. A wrong one is logged, and left out."""
        self._set(transform, authority, is_static=False)

    def set_transform_static(self, transform: Any, authority: str) -> None:
        """Add one that holds for all times."""
        self._set(transform, authority, is_static=True)

    def _set(self, message: Any, authority: str, *, is_static: bool) -> None:
        child = message.child_frame_id.removeprefix("/")
        parent, moved, turned = message.header.frame_id.removeprefix("/"), *_parts(message.transform)
        faults = list(_faults(parent, child, authority, moved, turned))
        for fault in faults:
            _log("error", fault)
        if faults:
            return
        stamp_ns = _ns(message.header.stamp)
        if not self._tree.insert(
            child, StampedTransform(moved, turned, stamp_ns, parent), authority, is_static=is_static
        ):
            _log(
                "warning",
                f"TF_OLD_DATA ignoring data from the past for frame {child} at time {seconds(stamp_ns)} according to "
                f"authority {authority}",
            )

    def can_transform_core(self, target_frame: str, source_frame: str, time: Any) -> tuple[int, str]:
        """Whether there is a transform, as 0 or 1; and why not."""
        if target_frame == source_frame:
            return 1, ""
        for frame, argument in ((target_frame, "target_frame"), (source_frame, "source_frame")):
            if fault := self._tree.invalid(frame, f"canTransform argument {argument}"):
                return 0, fault
        return self._tree.connects(target_frame, source_frame, _ns(time))

    def can_transform_full_core(
        self, target_frame: str, target_time: Any, source_frame: str, source_time: Any, fixed_frame: str
    ) -> tuple[int, str]:
        """Whether there is a transform between two times, by a frame that does not move in between; and why not."""
        named = {"target_frame": target_frame, "source_frame": source_frame, "fixed_frame": fixed_frame}
        for argument, frame in named.items():
            if fault := self._tree.invalid(frame, f"canTransform argument {argument}"):
                return 0, fault
        result = self._tree.connects(target_frame, fixed_frame, _ns(target_time))
        return self._tree.connects(fixed_frame, source_frame, _ns(source_time)) if result[0] else result

    def lookup_transform_core(self, target_frame: str, source_frame: str, time: Any) -> Any:
        """The transform from the source to the target frame, as a `TransformStamped`; that of time 0 is the latest.

        Raises:
            LookupException: there is no such frame.
            ConnectivityException: no chain of frames connects them.
            ExtrapolationException: the time is not between those that are known.
            InvalidArgumentException: a frame without a name, or with a slash before it.
        """
        transform, time_ns = self._tree.lookup(target_frame, source_frame, _ns(time))
        return _message(target_frame, source_frame, transform, time_ns)

    def lookup_transform_full_core(
        self, target_frame: str, target_time: Any, source_frame: str, source_time: Any, fixed_frame: str
    ) -> Any:
        """From where the source frame was at its time, to the target frame at its time. Raises as the other one."""
        named = {"target_frame": target_frame, "source_frame": source_frame, "fixed_frame": fixed_frame}
        for argument, frame in named.items():
            self._tree.require(frame, f"lookupTransform argument {argument}")
        first, _ = self._tree.lookup(fixed_frame, source_frame, _ns(source_time))
        second, time_ns = self._tree.lookup(target_frame, fixed_frame, _ns(target_time))
        return _message(target_frame, source_frame, second.after(first), time_ns)

    def get_latest_common_time(self, target_frame: str, source_frame: str) -> Any:
        """The latest time at which there is a transform, as a `rclpy.time.Time`. Raises as `lookup_transform_core`."""
        from rclpy.time import Time

        self._tree.require(target_frame, "get_latest_common_time")
        self._tree.require(source_frame, "get_latest_common_time")
        return Time(nanoseconds=self._tree.common_ns(target_frame, source_frame))

    def lookupVelocityCore(  # noqa: N802 (the name is tf2's)
        self, tracking_frame: str, observation_frame: str, time: Any, averaging_interval: Any
    ) -> tuple[Vector, Vector]:
        """The velocity of a frame, linear (m/s) and angular (rad/s), over an interval around a time."""
        return self.lookupVelocityFullCore(
            tracking_frame, observation_frame, observation_frame, NO_WAY, tracking_frame, time, averaging_interval
        )

    def lookupVelocityFullCore(  # noqa: N802 (name and arguments are tf2's)
        self,
        tracking_frame: str,
        observation_frame: str,
        reference_frame: str,
        reference_point: Vector,
        reference_point_frame: str,
        time: Any,
        averaging_interval: Any,
    ) -> tuple[Vector, Vector]:
        """The same, of a point, in a frame of reference. Raises as `lookup_transform_core`."""
        latest_s = 0.0
        if {observation_frame, tracking_frame} <= set(self._tree.names):
            latest_s = self._tree.common_ns(observation_frame, tracking_frame) / 1e9
        time_ns, interval_s = _ns(time), _ns(averaging_interval) / 1e9
        end_s = min(time_ns / 1e9 + interval_s * 0.5, latest_s)
        start_s = max(0.00001 + interval_s, end_s) - interval_s  # as tf2: 0 would be the latest time
        took_s = end_s - start_s
        start, _ = self._tree.lookup(observation_frame, tracking_frame, round(start_s * 1e9))
        end, _ = self._tree.lookup(observation_frame, tracking_frame, round(end_s * 1e9))
        turned = product(inverse(start.rotation), end.rotation)
        moved = add(end.translation, negate(start.translation))
        twist = rotate(start.rotation, _scale(_axis(turned), _angle(turned) / took_s))
        to_reference, _ = self._tree.lookup(reference_frame, tracking_frame, time_ns)
        angular = rotate(to_reference.rotation, twist)
        linear = add(
            rotate(to_reference.rotation, _scale(moved, 1.0 / took_s)), cross(to_reference.translation, angular)
        )
        point_to_reference, _ = self._tree.lookup(reference_frame, reference_point_frame, time_ns)
        delta = add(point_to_reference.of(reference_point), negate(to_reference.of(NO_WAY)))
        # As tf2 has it: the product of the components, where a cross product was meant.
        further = (angular[0] * delta[0], angular[1] * delta[1], angular[2] * delta[2])
        return add(linear, further), angular

    def all_frames_as_string(self) -> str:
        """A sentence for each frame that has a parent."""
        return self._tree.all_frames_as_string()

    def all_frames_as_yaml(self) -> str:
        """The frames that have a parent, with how often and how lately they came."""
        return self._tree.all_frames_as_yaml()

    def _frameExists(self, frame_id: str) -> bool:  # noqa: N802 (the name is tf2's)
        return frame_id in self._tree.names

    def _getFrameStrings(self) -> list[str]:  # noqa: N802 (the name is tf2's)
        return self._tree.names


def _scale(v: Vector, by: float) -> Vector:
    return (v[0] * by, v[1] * by, v[2] * by)


def _axis(q: tuple[float, float, float, float]) -> Vector:
    length_squared = 1.0 - min(1.0, q[3] * q[3])
    if length_squared < sys.float_info.epsilon * 10:
        return (1.0, 0.0, 0.0)  # of no rotation: any
    return _scale((q[0], q[1], q[2]), 1.0 / math.sqrt(length_squared))


def _angle(q: tuple[float, float, float, float]) -> float:
    return 2.0 * math.acos(max(-1.0, min(1.0, q[3])))


def _parts(transform: Any) -> tuple[Vector, tuple[float, float, float, float]]:
    t, q = transform.translation, transform.rotation
    return (float(t.x), float(t.y), float(t.z)), (float(q.x), float(q.y), float(q.z), float(q.w))


def _faults(
    parent: str, child: str, authority: str, moved: Vector, turned: tuple[float, float, float, float]
) -> Iterator[str]:
    """What is wrong with a transform, in the words of tf2."""
    if child == parent:
        yield (
            f'TF_SELF_TRANSFORM: Ignoring transform from authority "{authority}" with frame_id and  child_frame_id '
            f'"{child}" because they are the same'
        )
    if not child:
        yield f'TF_NO_CHILD_FRAME_ID: Ignoring transform from authority "{authority}" because child_frame_id not set '
    if not parent:
        yield (
            f'TF_NO_FRAME_ID: Ignoring transform with child_frame_id "{child}"  from authority "{authority}" because '
            "frame_id not set"
        )
    of = f'Ignoring transform for child_frame_id "{child}" from authority "{authority}" because of'
    values = [" ".join(f"{value:f}" for value in part) for part in (moved, turned)]
    if any(math.isnan(value) for value in (*moved, *turned)):
        yield f"TF_NAN_INPUT: {of} a nan value in the transform ({values[0]}) ({values[1]})"
    if not abs(sum(value * value for value in turned) - 1.0) < _TOLERANCE:
        yield f"TF_DENORMALIZED_QUATERNION: {of} an invalid quaternion in the transform ({values[1]})"


def _log(severity: str, text: str) -> None:
    from rclpy.logging import get_logger

    getattr(get_logger("tf2"), severity)(text)


def _message(target: str, source: str, transform: Transform, time_ns: int) -> Any:
    from geometry_msgs.msg import TransformStamped

    message = TransformStamped(child_frame_id=source)
    message.header.frame_id = target
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(time_ns, 10**9)
    for part, names, values in (
        (message.transform.translation, "xyz", transform.translation),
        (message.transform.rotation, "xyzw", transform.rotation),
    ):
        for name, value in zip(names, values, strict=True):
            setattr(part, name, value)
    return message


def replace_tf2() -> None:
    """Put our module in the place of `tf2_py`, for this process, where it is not installed."""
    if NAME in sys.modules or importlib.util.find_spec(NAME) is not None:
        return
    module = ModuleType(NAME, __doc__)
    vars(module)["BufferCore"] = BufferCore
    vars(module).update({exception.__name__: exception for exception in EXCEPTIONS})
    sys.modules[NAME] = module
