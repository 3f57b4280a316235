"""Balanced selection."""

from __future__ import annotations

from collections import Counter

from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.generate.exploration import Exploration
from pytest_hricdv.generate.selection import balanced

explorations = st.lists(
    st.builds(
        lambda name, line, plans: Exploration((name,), (line,), {"a": frozenset(plans)}),
        st.sampled_from("pqrstu"),
        st.sampled_from(["wave", "leave"]),
        st.sets(st.sampled_from("12345")),
    ),
    max_size=12,
)


def _exploration(name: str, plans: str, line: str = "wave") -> Exploration:
    return Exploration((name,), (line,), {"a": frozenset(plans)})


def test_what_is_rare_is_kept() -> None:
    common = [_exploration(f"c{number}", "1") for number in range(20)]
    rare = [_exploration(f"r{number}", "12") for number in range(3)]
    assert set(balanced([*common, *rare], 6)) > set(rare)


def test_a_new_text_goes_before_a_known_one() -> None:
    found = [_exploration("a", "1"), _exploration("b", "1"), _exploration("c", "1", "leave")]
    assert [each.beliefs for each in balanced(found, 2)] == [("a",), ("c",)]


@given(explorations, st.integers(0, 14))
def test_a_selection_is_of_what_there_is(found: list[Exploration], count: int) -> None:
    chosen = balanced(found, count)
    assert len(chosen) == min(count, len(found))
    assert not Counter(map(repr, chosen)) - Counter(map(repr, found))


@given(explorations)
def test_every_plan_is_covered_while_there_is_room(found: list[Exploration]) -> None:
    plans = {plan for each in found for plan in each.plans["a"]}
    covered = {plan for each in balanced(found, 5) for plan in each.plans["a"]}
    assert covered == plans
