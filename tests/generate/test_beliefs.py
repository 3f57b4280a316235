"""The belief space and its errors."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.error import GenerateError
from tests.generate.table import SPACE


def test_the_table_has_38_beliefs_in_declared_order() -> None:
    assert len(SPACE.beliefs) == 38
    assert SPACE.beliefs[:8] == ("leg1", "leg2", "leg3", "leg4", "bored", "not_bored", "m000l1", "m001l1")
    assert SPACE.others == SPACE.beliefs[4:]


@given(st.permutations(SPACE.beliefs), st.integers(0, 38))
def test_a_subset_has_one_order_whatever_order_it_was_chosen_in(beliefs: list[str], size: int) -> None:
    subset = SPACE.subset(beliefs[:size])
    assert set(subset) == set(beliefs[:size])
    assert subset == SPACE.subset(reversed(subset))


@pytest.mark.parametrize(
    ("beliefs", "aim"),
    [
        (("m111l1", "bored", "leg1"), "leg1-bored"),
        (("leg4", "m000l4"), "leg4"),
        (("m000l4",), "no-start"),
        ((), "no-start"),
        (("not_bored",), "no-start-not_bored"),
    ],
)
def test_the_target_is_the_start_belief_and_the_naming_groups(beliefs: tuple[str, ...], aim: str) -> None:
    assert SPACE.target(beliefs) == aim


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: BeliefSpace((), {}), "group 'start' of beliefs is empty"),
        (lambda: BeliefSpace(("a",), {"g": ()}), "group 'g' of beliefs is empty"),
        (lambda: BeliefSpace(("a",), {"g": ("a",)}), "belief 'a' is in group 'start' and in group 'g'"),
        (lambda: BeliefSpace(("a", "a"), {}), "belief 'a' is in group 'start' and in group 'start'"),
        (lambda: BeliefSpace(("Leg",), {}), "'Leg' is no belief"),
        (lambda: BeliefSpace(("a b",), {}), "'a b' is no belief"),
        (lambda: BeliefSpace(("a",), {"mood": ("b",)}, naming=("moods",)), "'moods' is no group.*nearest: mood"),
        (
            lambda: BeliefSpace(("a",), {"mood": ("b",)}, neutral=("c",)),
            "neutral belief 'c' is not in the belief space",
        ),
        (lambda: BeliefSpace(("a",), {"start": ("b",)}), "have this name already"),
        (lambda: SPACE.subset(["leg5"]), "'leg5' is not in the belief space; nearest: leg4"),
        (lambda: SPACE.subset(["leg1", "leg1"]), "'leg1' is given twice"),
    ],
)
def test_invalid_arguments_are_errors(make: Callable[[], object], message: str) -> None:
    with pytest.raises(GenerateError, match=message):
        make()
