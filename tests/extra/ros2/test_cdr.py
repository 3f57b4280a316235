"""Messages as bytes."""

from __future__ import annotations

import array
from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

import pytest

from pytest_hricdv.extra.ros2.messages import CdrError, deserialize, import_type, serialize

_FILES = {
    "cell_io/msg/Empty.msg": "",
    "cell_io/msg/Point.msg": "uint8 kind\nfloat64 x\n",
    "cell_io/msg/Scan.msg": "bool on\nstring text\nwstring wide\nint64[] ranges\nuint16[3] three\nPoint point\n"
    "Point[] points\nstring[] texts\n",
}


@pytest.fixture
def cell_io(interfaces: Callable[[Mapping[str, str]], None]) -> Any:
    """The classes of some messages."""
    interfaces(_FILES)
    names = ("Empty", "Point", "Scan")
    return SimpleNamespace(**{name: import_type(f"cell_io/msg/{name}", "msg") for name in names})


def test_bytes_are_those_of_the_standard(cell_io: Any) -> None:
    """Each number on a multiple of its size, counted from after the header; a text ends with a zero."""
    Empty, Point, Scan = cell_io.Empty, cell_io.Point, cell_io.Scan  # noqa: N806
    assert serialize(Point(kind=7, x=1.0), Point).hex(" ") == (
        "00 01 00 00 07 00 00 00 00 00 00 00 00 00 00 00 00 00 f0 3f"
    )
    scan = Scan(on=True, text="hé", three=[1, 2, 3], ranges=array.array("q", [-1]))
    assert serialize(scan, Scan)[4:].hex(" ").startswith("01 00 00 00 04 00 00 00 68 c3 a9 00 00 00 00 00 01 00 00 00")
    assert serialize(Empty(), Empty) == b"\x00\x01\x00\x00\x00"


def test_bytes_of_another_order_are_refused(cell_io: Any) -> None:
    with pytest.raises(CdrError, match="Point: expected little-endian CDR"):
        deserialize(b"\x00\x00\x00\x00\x07", cell_io.Point)
