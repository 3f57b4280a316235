"""Messages in messages, and lists in them, as a record has them."""

from __future__ import annotations

import subprocess
import sys
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.runtime import Bus, Kernel, Recorder, fields_of
from pytest_hricdv.runtime.message_fields import record_fields


@dataclass
class Odd:
    what: object


def fields(message: object) -> dict[str, object]:
    return {**record_fields(message, fields_of(type(message)) or ())}


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
