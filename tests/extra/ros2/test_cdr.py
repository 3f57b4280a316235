"""Messages as bytes."""

from __future__ import annotations

import array
from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

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


_POINTS = st.fixed_dictionaries({"kind": st.integers(0, 255), "x": st.floats(allow_nan=False)})
_TEXTS = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"))


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    fields=st.fixed_dictionaries(
        {
            "on": st.booleans(),
            "text": _TEXTS,
            "wide": _TEXTS,
            "ranges": st.lists(st.integers(-(2**63), 2**63 - 1)),
            "three": st.lists(st.integers(0, 65535), min_size=3, max_size=3),
            "point": _POINTS,
            "points": st.lists(_POINTS),
            "texts": st.lists(st.text("ab")),
        }
    )
)
def test_what_is_written_is_read_back(cell_io: Any, fields: dict[str, Any]) -> None:
    point, points = cell_io.Point(**fields["point"]), [cell_io.Point(**each) for each in fields["points"]]
    scan = cell_io.Scan(**{**fields, "point": point, "points": points})
    data = serialize(scan, cell_io.Scan)
    assert deserialize(data, cell_io.Scan) == scan
    with pytest.raises(CdrError, match=r"Scan: \d+ bytes are too few"):
        deserialize(data[:-1] if scan.texts else data[:-4], cell_io.Scan)


def test_bytes_of_another_order_are_refused(cell_io: Any) -> None:
    with pytest.raises(CdrError, match="Point: expected little-endian CDR"):
        deserialize(b"\x00\x00\x00\x00\x07", cell_io.Point)


def test_a_type_without_representation_is_named() -> None:
    class Long:
        SLOT_TYPES = (SimpleNamespace(typename="long double"),)
        x = 0.0

        @classmethod
        def get_fields_and_field_types(cls) -> dict[str, str]:
            return {"x": "long double"}

    with pytest.raises(CdrError, match="a field of type long double has no representation"):
        serialize(Long(), Long)
