"""The interactions of a test, and the interventions in them."""

from __future__ import annotations

from collections.abc import Sequence

from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.extra.closing.interactions import (
    Combination,
    Intervention,
    combinations_of,
    commands_of,
    insert_combinations,
    interactions_of,
    starts_of,
)

SCRIPT = ("enter", "ask", "take", "ask", "wait", "take")


def planned(commands: Sequence[str]) -> tuple[tuple[str], ...]:
    """One interaction for each question; whether it ends with taking depends on the whole test."""
    return tuple(("taken" if "take" in commands else "left",) for command in commands if command == "ask")


def test_an_interaction_begins_where_one_more_is_planned() -> None:
    assert starts_of(SCRIPT, planned) == (1, 3)


def test_a_disturbance_between_two_interactions_belongs_to_the_first_one() -> None:
    lines = ("enter", "disturb a", "ask", "take", "disturb b", "ask", "disturb c", "wait", "take", "disturb d")
    values = {2: {"x": 1.5}, 10: {"y": 2.0}}
    assert combinations_of(lines, values, (1, 3)) == (
        (Intervention(0, "a", (("x", 1.5),)), Intervention(2, "b")),
        (Intervention(1, "c"), Intervention(3, "d", (("y", 2.0),))),
    )


interventions = st.builds(Intervention, st.integers(1, 2), st.sampled_from("abc"), st.sampled_from(((), (("x", 0.5),))))
combinations = st.lists(interventions, max_size=3).map(
    lambda found: tuple(sorted(found, key=lambda intervention: intervention.place))
)


@given(combinations, combinations)
def test_interventions_in_a_test_are_read_back(one: Combination, two: Combination) -> None:
    lines, values = insert_combinations(SCRIPT, (1, 3), (one, two))
    assert commands_of(lines) == SCRIPT
    assert combinations_of(lines, values, (1, 3)) == (one, two)


def test_an_interaction_has_the_bin_that_was_hit_in_its_place() -> None:
    hits = {"ends": (("taken", "well"), ("taken", "badly")), "seen": (("dark",), ("light",))}
    first, second = interactions_of(("disturb a", *SCRIPT), {}, hits, "ends", planned)
    assert (first.planned, first.combination) == (("taken",), (Intervention(-1, "a"),))
    assert first.effect == (("ends", "well"), ("seen", "dark"))
    assert second.effect == (("ends", "badly"), ("seen", "light"))
    assert len(interactions_of(SCRIPT, {}, {"ends": (("taken", "well"),)}, "ends", planned)) == 1


def test_an_interaction_without_a_bin_leaves_the_others_theirs() -> None:
    def by_name(commands: Sequence[str]) -> tuple[tuple[str], ...]:
        return tuple((command.removeprefix("ask "),) for command in commands if command.startswith("ask"))

    lines = ("ask a", "disturb x", "ask b", "ask c", "disturb y")
    hits = {"ends": (("a", "well"), ("c", "badly")), "seen": (("dark",), ("light",)), "heard": (("much",),)}
    first, last = interactions_of(lines, {}, hits, "ends", by_name)
    assert (first.planned, first.effect) == (("a",), (("ends", "well"), ("seen", "dark")))
    assert (last.planned, last.combination) == (("c",), (Intervention(1, "y"),))
    assert last.effect == (("ends", "badly"), ("seen", "light"))
    assert (first.is_isolated, last.is_isolated) == (True, False)
