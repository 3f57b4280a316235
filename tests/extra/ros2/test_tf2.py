"""What stands for the C++ part of tf2: the tree of frames, in time, with tf2's words where there is no transform.

tf2's own tests in Python (ros2/geometry2: tf2_py, tf2_ros_py) were run on it, too; see docs/ros2.md.
"""

from __future__ import annotations

import math
import sys
from importlib.util import find_spec
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.extra.ros2 import tf2
from pytest_hricdv.extra.ros2.frame_tree import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
)
from pytest_hricdv.extra.ros2.tf2 import BufferCore
from pytest_hricdv.extra.ros2.transforms import Quaternion, Transform, inverse, product, rotate

_TURN = (0.0, 0.0, math.sin(math.pi / 4), math.cos(math.pi / 4))
"""By 90 degrees about z."""


@pytest.fixture(autouse=True)
def logged(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What is logged: there may be no rclpy."""
    texts: list[str] = []
    monkeypatch.setattr(tf2, "_log", lambda severity, text: texts.append(text))
    return texts


def _time(time_s: float) -> Any:
    return SimpleNamespace(nanoseconds=round(time_s * 1e9))


def _moved(parent: str, child: str, time_s: float, x: float, rotation: Quaternion = (0.0, 0.0, 0.0, 1.0)) -> Any:
    return SimpleNamespace(
        header=SimpleNamespace(frame_id=parent, stamp=_time(time_s)),
        child_frame_id=child,
        transform=SimpleNamespace(
            translation=SimpleNamespace(x=x, y=0.0, z=0.0),
            rotation=SimpleNamespace(**dict(zip("xyzw", rotation, strict=True))),
        ),
    )


def _buffer(*transforms: Any, static: tuple[Any, ...] = ()) -> BufferCore:
    buffer = BufferCore()
    for transform in transforms:
        buffer.set_transform(transform, "test")
    for transform in static:
        buffer.set_transform_static(transform, "test")
    return buffer


def _looked_up(buffer: BufferCore, target: str, source: str, time_s: float) -> Transform:
    return buffer._tree.lookup(target, source, round(time_s * 1e9))[0]


def test_a_transform_between_two_times_is_interpolated() -> None:
    buffer = _buffer(_moved("map", "base", 1.0, 0.0), _moved("map", "base", 3.0, 4.0, _TURN))
    transform = _looked_up(buffer, "map", "base", 2.0)
    assert transform.translation == pytest.approx((2.0, 0.0, 0.0))
    assert transform.rotation == pytest.approx((0.0, 0.0, math.sin(math.pi / 8), math.cos(math.pi / 8)))


def test_frames_are_connected_up_and_down_the_tree() -> None:
    left, right = _moved("map", "left", 1.0, 1.0, _TURN), _moved("map", "right", 1.0, 3.0)
    buffer = _buffer(left, right, static=(_moved("left", "hand", 0.0, 2.0),))
    assert _looked_up(buffer, "map", "hand", 1.0).translation == pytest.approx((1.0, 2.0, 0.0))
    assert _looked_up(buffer, "right", "hand", 1.0).translation == pytest.approx((-2.0, 2.0, 0.0))
    assert _looked_up(buffer, "hand", "right", 1.0).of((0.0, 0.0, 0.0)) == pytest.approx((-2.0, -2.0, 0.0))
    assert _looked_up(buffer, "hand", "hand", 7.0) == Transform()


_MOVES = [_moved("map", "base", 1.0, 0.0), _moved("map", "base", 2.0, 1.0), _moved("island", "tree", 1.0, 0.0)]
_ASKED = ", when looking up transform from frame [base] to frame [map]"


@pytest.mark.parametrize(
    ("target", "source", "time_s", "kind", "text"),
    [
        ("map", "base", 2.5, ExtrapolationException, "Lookup would require extrapolation into the future.  Requested "
         "time 2.500000 but the latest data is at time 2.000000" + _ASKED),
        ("map", "base", 0.5, ExtrapolationException, "Lookup would require extrapolation into the past.  Requested "
         "time 0.500000 but the earliest data is at time 1.000000" + _ASKED),
        ("island", "tree", 2.0, ExtrapolationException, "Lookup would require extrapolation at time 2.000000, but only "
         "time 1.000000 is in the buffer, when looking up transform from frame [tree] to frame [island]"),
        ("map", "nose", 1.0, LookupException, '"nose" passed to lookupTransform argument source_frame '
         "does not exist. "),
        ("", "base", 1.0, InvalidArgumentException, 'Invalid argument "" passed to lookupTransform argument '
         "target_frame - in tf2 frame_ids cannot be empty"),
        ("/map", "base", 1.0, InvalidArgumentException, 'Invalid argument "/map" passed to lookupTransform argument '
         "target_frame - in tf2 frame_ids cannot start with a '/'"),
        ("map", "tree", 1.0, ConnectivityException, "Could not find a connection between 'map' and 'tree' because they "
         "are not part of the same tree.Tf has two or more unconnected trees."),
        ("map", "tree", 0.0, ConnectivityException, "Could not find a connection between 'map' and 'tree' because they "
         "are not part of the same tree.Tf has two or more unconnected trees."),
    ],
)  # fmt: skip
def test_where_there_is_no_transform_it_is_said_as_tf2_says_it(
    target: str, source: str, time_s: float, kind: type[Exception], text: str
) -> None:
    buffer = _buffer(*_MOVES)
    with pytest.raises(kind) as raised:
        _looked_up(buffer, target, source, time_s)
    assert str(raised.value) == text
    can, why = buffer.can_transform_core(target, source, _time(time_s))
    assert can == 0
    assert why == text or why.startswith("Invalid frame ID")


@pytest.mark.parametrize(
    ("transform", "text"),
    [
        (_moved("base", "base", 1.0, 0.0), "TF_SELF_TRANSFORM: Ignoring transform from authority"),
        (_moved("map", "", 1.0, 0.0), "TF_NO_CHILD_FRAME_ID"),
        (_moved("", "base", 1.0, 0.0), "TF_NO_FRAME_ID"),
        (_moved("map", "base", 1.0, math.nan), "TF_NAN_INPUT"),
        (_moved("map", "base", 1.0, 0.0, (0.0, 0.0, 0.0, 0.0)), "TF_DENORMALIZED_QUATERNION"),
    ],
)
def test_a_wrong_transform_is_logged_and_left_out(transform: Any, text: str, logged: list[str]) -> None:
    buffer = _buffer(transform)
    assert logged[0].startswith(text)
    assert not buffer._frameExists("base")


_UNIT = st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: math.hypot(*q) > 0.1)
_ROTATIONS = _UNIT.map(lambda q: tuple(value / math.hypot(*q) for value in q))
_VECTORS = st.tuples(*[st.floats(-100.0, 100.0)] * 3)


@given(_ROTATIONS, _VECTORS, _ROTATIONS, _VECTORS, _VECTORS)
def test_transforms_compose_and_invert(a: Any, moved_a: Any, b: Any, moved_b: Any, point: Any) -> None:
    first, second = Transform(moved_a, a), Transform(moved_b, b)
    assert second.after(first).of(point) == pytest.approx(second.of(first.of(point)), abs=1e-9)
    assert first.inverse().of(first.of(point)) == pytest.approx(point, abs=1e-9)
    assert rotate(product(a, inverse(a)), point) == pytest.approx(point, abs=1e-9)


@pytest.mark.skipif(find_spec("tf2_py") is not None, reason="tf2_py is installed")
def test_it_stands_for_tf2_py_where_that_is_not_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "tf2_py", None)  # so that it is put back
    del sys.modules["tf2_py"]
    tf2.replace_tf2()
    assert vars(sys.modules["tf2_py"])["BufferCore"] is BufferCore
    assert issubclass(vars(sys.modules["tf2_py"])["LookupException"], vars(sys.modules["tf2_py"])["TransformException"])
