"""Messages in messages, and lists in them, as a record has them."""

from __future__ import annotations

import subprocess
import sys
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.message_types import comparable_fields
from pytest_hricdv.runtime import Bus, Kernel, Recorder, fields_of
from pytest_hricdv.runtime.message_fields import record_fields


class Room(Enum):
    KITCHEN = "kitchen"
    HALL = "hall"


class Place(NamedTuple):
    room: Room
    x_m: float = 0.0


@dataclass(frozen=True)
class Order:
    to: Place
    items: tuple[str, ...] = ()
    note: str | None = None
    by_way_of: list[Place] = field(default_factory=list)


@dataclass
class Branch:
    name: str
    below: Branch | None = None


@dataclass
class Odd:
    what: object


def fields(message: object) -> dict[str, object]:
    return {**record_fields(message, fields_of(type(message)) or ())}


def test_a_message_in_a_message_has_paths_and_what_is_none_is_left_out() -> None:
    assert fields(Order(Place(Room.HALL, 2.5), ("cup",))) == {
        "to.room": "hall", "to.x_m": 2.5, "items.length": 1, "items.crc": fields(Odd(("cup",)))["what.crc"],
        "by_way_of.length": 0, "by_way_of.crc": fields(Odd([]))["what.crc"],
    }  # fmt: skip
    assert fields(Branch("one", Branch("two"))) == {"name": "one", "below.name": "two"}


def test_requirements_compare_what_is_always_there() -> None:
    assert {name: (kind, texts) for name, kind, texts in comparable_fields(Order)} == {
        "to.room": (str, ("kitchen", "hall")), "to.x_m": (float, ()),
        "items.length": (float, ()), "items.crc": (float, ()),
        "by_way_of.length": (float, ()), "by_way_of.crc": (float, ()),
    }  # fmt: skip
    assert [name for name, _, _ in comparable_fields(Branch)] == ["name"]


contents = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=3),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=2), inner, max_size=3),
    max_leaves=8,
)


@given(st.lists(contents, max_size=4), st.lists(contents, max_size=4))
def test_contents_that_differ_have_checksums_that_differ(one: Sequence[object], other: Sequence[object]) -> None:
    assert (fields(Odd(one)) == fields(Odd(other))) == (repr(_in_order(one)) == repr(_in_order(other)))


def _in_order(value: object) -> object:
    """A value with the keys of its dicts in one order."""
    if isinstance(value, dict):
        return {key: _in_order(value[key]) for key in sorted(value)}
    return [*map(_in_order, value)] if isinstance(value, list) else value


def test_a_set_has_one_checksum_in_each_process() -> None:
    script = "from tests.runtime.test_message_fields import Odd, fields; print(fields(Odd({'a', 'b', 'cup', 'hall'})))"
    said = {
        subprocess.run([sys.executable, "-c", script], env={"PYTHONHASHSEED": seed, "PYTHONPATH": ":".join(sys.path)},
                       capture_output=True, text=True, check=True).stdout
        for seed in "012"
    }  # fmt: skip
    assert len(said) == 1


def test_what_has_no_content_of_its_own_is_refused_with_its_path() -> None:
    kernel = Kernel()
    bus = Bus(kernel, [Odd], Recorder())
    for value in (object(), [1, object()], {"a": len}, Odd(deque([print]))):
        with pytest.raises(
            TypeError, match=r"message Odd at 0\.000000 s: what(\.what)? is .*: expected a number, a bool"
        ):
            bus.port("robot").publish(Odd(value))
