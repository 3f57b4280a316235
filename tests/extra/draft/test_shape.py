from __future__ import annotations

import json
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.extra.draft.observe.shape import MAX_TEXTS, Shape

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-9, 9) | st.floats() | st.text(max_size=5) | st.binary(max_size=3),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
    max_leaves=8,
)


def shape_of(values: list[Any]) -> Shape:
    made = Shape()
    for value in values:
        made.add(value)
    return made


@given(st.lists(VALUES), st.lists(VALUES))
def test_merged_shapes_are_that_of_all_values(first: list[Any], second: list[Any]) -> None:
    merged, both = shape_of(first), shape_of(first + second)
    merged.merge(shape_of(second))
    assert (merged.count, merged.kinds, merged.low, merged.high) == (both.count, both.kinds, both.low, both.high)
    assert set(both.texts) <= set(merged.texts)
    assert set(both.fields) <= set(merged.fields)


@given(st.lists(VALUES))
def test_a_shape_is_read_as_it_was_written(values: list[Any]) -> None:
    made = shape_of(values)
    assert Shape.from_json(json.loads(json.dumps(made.to_json()))) == made


def test_strings_named_like_secrets_are_masked_at_any_depth() -> None:
    headers = {"Authorization": "Bearer x-1", "Set-Cookie": "x-2", "X-Api-Key": "x-3", "Accept": "text/plain"}
    written = json.dumps(shape_of([{"headers": headers}, {"access_key": "x-4"}]).to_json())
    assert "x-" not in written
    assert "text/plain" in written


def test_a_text_with_many_values_is_open() -> None:
    made = shape_of([f"text {number}" for number in range(MAX_TEXTS + 1)])
    assert len(made.texts) == MAX_TEXTS
    assert made.is_open


def test_json_in_texts_and_bytes_is_read() -> None:
    made = shape_of(['{"kind": "tour"}', b'{"kind": "home"}', "{no json"])
    assert made.fields["kind"].texts == {"tour": 1, "home": 1}
    assert made.kinds == {"json": 1, "bytes": 1, "text": 1}
