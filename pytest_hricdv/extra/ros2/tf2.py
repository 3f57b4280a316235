"""Replaces `tf2_py`, the C++ part of tf2, if it is not installed: `tf2_ros` for Python runs on this module.

`overlay.replace_extension` calls `replace_tf2`. `BufferCore` keeps its transforms in a `FrameTree`. Names, messages of
errors and results are those of tf2's `BufferCore`; tf2's own tests in Python are run on this one.
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
from pytest_hricdv.extra.ros2.messages import set_stamp, stamp_ns
from pytest_hricdv.extra.ros2.transforms import (
    StampedTransform,
    Transform,
    Vector,
    seconds,
)

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

NAME = "tf2_py"
_CACHE_NS = 10 * 10**9
"""How long transforms are kept by default (ns): `tf2::BUFFER_CORE_DEFAULT_CACHE_TIME`."""
_TOLERANCE = 10e-3
"""Tolerance of the squared length of a quaternion, as `QUATERNION_NORMALIZATION_TOLERANCE` of tf2."""


def _ns(time: Any) -> int:
    """The nanoseconds of a time or duration, of messages or `rclpy`. Raises TypeError for anything else."""
    if hasattr(time, "sec") and hasattr(time, "nanosec"):
        return stamp_ns(time)
    if hasattr(time, "nanoseconds"):
        return int(time.nanoseconds)
    raise TypeError("time must have sec and nanosec, or nanoseconds.")


class BufferCore:
    """Like `tf2_py.BufferCore`: the tree of frames, with transforms over the duration `cache_time` (default: 10 s)."""

    def __init__(self, cache_time: Any = None) -> None:
        with suppress(ImportError):  # as the extension: who uses it finds these in `rclpy`, where that can be loaded
            importlib.import_module("rclpy.time")
            importlib.import_module("rclpy.duration")
        self._tree = FrameTree(_CACHE_NS if cache_time is None else _ns(cache_time))
        self.clear = self._tree.clear
        self.all_frames_as_string = self._tree.all_frames_as_string
        self.all_frames_as_yaml = self._tree.all_frames_as_yaml

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
        fault = self._invalid(target_frame=target_frame, source_frame=source_frame)
        return (0, fault) if fault else self._tree.can_transform(target_frame, source_frame, _ns(time))

    def _invalid(self, **frames: str) -> str:
        """What is wrong with the first wrong frame name; empty for nothing."""
        faults = (self._tree.name_problem(frame, f"canTransform argument {name}") for name, frame in frames.items())
        return next(filter(None, faults), "")

    def can_transform_full_core(
        self, target_frame: str, target_time: Any, source_frame: str, source_time: Any, fixed_frame: str
    ) -> tuple[int, str]:
        """Whether there is a transform between two times, by a frame that does not move in between; and why not."""
        fault = self._invalid(target_frame=target_frame, source_frame=source_frame, fixed_frame=fixed_frame)
        if fault:
            return 0, fault
        result = self._tree.can_transform(target_frame, fixed_frame, _ns(target_time))
        return self._tree.can_transform(fixed_frame, source_frame, _ns(source_time)) if result[0] else result

    def lookup_transform_core(self, target_frame: str, source_frame: str, time: Any) -> Any:
        """The transform from the source to the target frame, as a `TransformStamped`; time 0 means the latest.

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
        """The transform from the source frame at its time to the target frame at its time. Raises as the other one."""
        frames = {"target_frame": target_frame, "source_frame": source_frame, "fixed_frame": fixed_frame}
        for argument, frame in frames.items():
            self._tree.require(frame, f"lookupTransform argument {argument}")
        first, _ = self._tree.lookup(fixed_frame, source_frame, _ns(source_time))
        second, time_ns = self._tree.lookup(target_frame, fixed_frame, _ns(target_time))
        return _message(target_frame, source_frame, second.after(first), time_ns)

    def get_latest_common_time(self, target_frame: str, source_frame: str) -> Any:
        """The latest time with a transform, as `rclpy.time.Time`. Raises the same errors as `lookup_transform_core`."""
        from rclpy.time import Time

        self._tree.require(target_frame, "get_latest_common_time")
        self._tree.require(source_frame, "get_latest_common_time")
        return Time(nanoseconds=self._tree.common_ns(target_frame, source_frame))

    def _frameExists(self, frame_id: str) -> bool:  # noqa: N802 (the name is tf2's)
        return frame_id in self._tree.names

    def _getFrameStrings(self) -> list[str]:  # noqa: N802 (the name is tf2's)
        return self._tree.names


def _parts(transform: Any) -> tuple[Vector, tuple[float, float, float, float]]:
    t, q = transform.translation, transform.rotation
    return (float(t.x), float(t.y), float(t.z)), (float(q.x), float(q.y), float(q.z), float(q.w))


def _faults(
    parent: str, child: str, authority: str, moved: Vector, turned: tuple[float, float, float, float]
) -> Iterator[str]:
    """What is wrong with a transform, in the words of tf2."""
    ignoring = f'Ignoring transform from authority "{authority}"'
    if child == parent:
        text = f'{ignoring} with frame_id and  child_frame_id "{child}" because they are the same'
        yield f"TF_SELF_TRANSFORM: {text}"
    if not child:
        yield f"TF_NO_CHILD_FRAME_ID: {ignoring} because child_frame_id not set "
    if not parent:
        text = f'with child_frame_id "{child}"  from authority "{authority}" because frame_id not set'
        yield f"TF_NO_FRAME_ID: Ignoring transform {text}"
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
    set_stamp(message.header.stamp, time_ns)
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
