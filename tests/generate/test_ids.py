"""Ids and seeds from content."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.generate import ids
from pytest_hricdv.generate.ids import Draft, identify
from tests.generate.strategies import commands, words

drafts = st.builds(
    Draft,
    target=st.text(max_size=10).map(lambda text: " ".join(text.split()) or "x"),
    beliefs=st.lists(words, max_size=3).map(tuple),
    lines=st.lists(commands, max_size=3).map(tuple),
)
BY_CONTENT: Callable[[Draft], object] = lambda draft: (draft.beliefs, draft.lines)  # noqa: E731


def test_ids_and_seeds_are_those_of_earlier_versions() -> None:
    """If this fails, every id and recorded seed has changed: raise GENERATOR_VERSION and note it in the changelog."""
    (test,) = identify("by-hand", 0, [Draft("leg4", ("leg4", "m111l4"), ("tell leg", "receivesignal"))])
    assert (test.id, test.seed) == ("by-hand-leg4-5444b870", 8698345077810159687)


@given(st.lists(drafts, max_size=6), st.integers(0, 99))
def test_ids_are_distinct_and_fit_for_a_command_line(listed: list[Draft], seed: int) -> None:
    tests = identify("some suite", seed, listed)
    assert len({test.id for test in tests}) == len(listed)
    assert all(re.fullmatch(r"some-suite-[A-Za-z0-9_-]+-[0-9a-f]{8}", test.id) for test in tests)
    assert all(0 <= test.seed < 2**63 for test in tests)


@given(st.lists(drafts, max_size=6, unique_by=BY_CONTENT), st.randoms())
def test_ids_do_not_depend_on_the_order(listed: list[Draft], random: object) -> None:
    mixed = list(listed)
    random.shuffle(mixed)  # type: ignore[attr-defined]
    assert set(identify("s", 1, mixed)) == set(identify("s", 1, listed))


def test_equal_texts_of_different_subsets_are_different_tests() -> None:
    one, other = identify("s", 0, [Draft("a", ("x",), ("bored",)), Draft("a", ("y",), ("bored",))])
    assert one.id != other.id
    assert one.seed != other.seed


def test_equal_drafts_have_different_ids() -> None:
    draft = Draft("a", ("x",), ("bored",))
    first, second, third = identify("s", 0, [draft] * 3)
    assert len({first.id, second.id, third.id}) == len({first.seed, second.seed, third.seed}) == 3
    assert identify("s", 0, [draft]) == (first,)


def test_the_master_seed_and_the_suite_change_seeds_and_ids() -> None:
    draft = Draft("a", ("x",), ("bored",))
    tests = [*identify("s", 0, [draft]), *identify("s", 1, [draft]), *identify("t", 0, [draft])]
    assert len({test.id for test in tests}) == len({test.seed for test in tests}) == 3


def test_colliding_short_ids_are_made_longer(monkeypatch: pytest.MonkeyPatch) -> None:
    real = ids.content_digest
    monkeypatch.setattr(ids, "content_digest", lambda *key: "0" * 8 + real(*key))
    one, other = identify("s", 0, [Draft("a", ("x",), ("bored",)), Draft("a", ("y",), ("bored",))])
    assert one.id != other.id
    assert len(one.id) == len("s-a-") + 16
