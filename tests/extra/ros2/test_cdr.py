"""Messages as bytes, on classes like those that `rosidl` generates."""

from __future__ import annotations

import array
from dataclasses import dataclass
from typing import Any, ClassVar

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.extra.ros2.messages import CdrError, deserialize, serialize


@dataclass(frozen=True)
class BasicType:
    typename: str


class UnboundedString:
    pass


class UnboundedWString:
    pass


@dataclass(frozen=True)
class NamespacedType:
    namespaces: tuple[str, ...]
    name: str


@dataclass(frozen=True)
class UnboundedSequence:
    value_type: Any


@dataclass(frozen=True)
class Array:
    value_type: Any
    size: int


class _Message:
    SLOT_TYPES: tuple[Any, ...] = ()
    DEFAULTS: ClassVar[dict[str, Any]] = {}

    def __init__(self, **values: Any) -> None:
        vars(self).update({**self.DEFAULTS, **values})

    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]:
        return dict.fromkeys(cls.DEFAULTS, "any")

    def __eq__(self, other: object) -> bool:
        return vars(self) == vars(other)

    __hash__ = None  # type: ignore[assignment]


class Empty(_Message):
    pass


class Point(_Message):
    SLOT_TYPES = (BasicType("uint8"), BasicType("double"))
    DEFAULTS: ClassVar[dict[str, Any]] = {"kind": 0, "x": 0.0}


class Scan(_Message):
    SLOT_TYPES = (
        BasicType("boolean"),
        UnboundedString(),
        UnboundedWString(),
        UnboundedSequence(BasicType("int64")),
        Array(BasicType("uint16"), 3),
        NamespacedType((__name__,), "Point"),
        UnboundedSequence(NamespacedType((__name__,), "Point")),
        UnboundedSequence(UnboundedString()),
    )
    DEFAULTS: ClassVar[dict[str, Any]] = {
        "on": False,
        "text": "",
        "wide": "",
        "ranges": array.array("q"),
        "three": [0, 0, 0],
        "point": Point(),
        "points": [],
        "texts": [],
    }


def test_bytes_are_those_of_the_standard() -> None:
    """Each number on a multiple of its size, counted from after the header; a text ends with a zero."""
    assert serialize(Point(kind=7, x=1.0), Point).hex(" ") == (
        "00 01 00 00 07 00 00 00 00 00 00 00 00 00 00 00 00 00 f0 3f"
    )
    scan = Scan(on=True, text="hé", three=[1, 2, 3], ranges=array.array("q", [-1]))
    assert serialize(scan, Scan)[4:].hex(" ").startswith("01 00 00 00 04 00 00 00 68 c3 a9 00 00 00 00 00 01 00 00 00")
    assert serialize(Empty(), Empty) == b"\x00\x01\x00\x00\x00"


_points = st.builds(Point, kind=st.integers(0, 255), x=st.floats(allow_nan=False))


@given(
    scan=st.builds(
        Scan,
        on=st.booleans(),
        text=st.text(st.characters(exclude_categories=["Cs"])),
        wide=st.text(st.characters(exclude_categories=["Cs"])),
        ranges=st.lists(st.integers(-(2**63), 2**63 - 1)).map(lambda values: array.array("q", values)),
        three=st.lists(st.integers(0, 65535), min_size=3, max_size=3),
        point=_points,
        points=st.lists(_points),
        texts=st.lists(st.text("ab")),
    )
)
def test_what_is_written_is_read_back(scan: Any) -> None:
    data = serialize(scan, Scan)
    assert deserialize(data, Scan) == scan
    with pytest.raises(CdrError, match=r"Scan: \d+ bytes are too few"):
        deserialize(data[:-1] if scan.texts else data[:-4], Scan)


def test_bytes_of_another_order_are_refused() -> None:
    with pytest.raises(CdrError, match="Point: expected little-endian CDR"):
        deserialize(b"\x00\x00\x00\x00\x07", Point)


def test_a_type_without_representation_is_named() -> None:
    class Long(_Message):
        SLOT_TYPES = (BasicType("long double"),)
        DEFAULTS: ClassVar[dict[str, Any]] = {"x": 0.0}

    with pytest.raises(CdrError, match="a field of type long double has no representation"):
        serialize(Long(), Long)
