"""The chooser by weights: seeded, in proportion, with those for its state and interaction first."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import pytest

from pytest_hricdv.online.chooser import (
    ACT,
    ANY_INTERACTION,
    ANY_STATE,
    GOAL,
    NONE,
    ChoicePoint,
    Situation,
    Weight,
    WeightedChooser,
)

ANYWHERE = Situation(0.0, "Waiting", 2, ())


def chosen(
    about: str, options: tuple[str, ...], weights: Sequence[Weight], times: int = 2000, seed: int = 1
) -> Counter[str]:
    """What is chosen how often."""
    chooser = WeightedChooser(1, weights)
    return Counter(chooser.choose(ChoicePoint(about, options, ANYWHERE)) for _ in range(times))


def everywhere(about: str, **weights: float) -> list[Weight]:
    """Weights of options in any state and interaction."""
    return [(ANY_STATE, ANY_INTERACTION, about, option, weight) for option, weight in weights.items()]


def test_the_same_seed_chooses_the_same_and_another_seed_something_else() -> None:
    def sequence(seed: int) -> list[str]:
        chooser = WeightedChooser(seed)
        return [chooser.choose(ChoicePoint("pose", ("a", "b", "c"), ANYWHERE)) for _ in range(20)]

    assert sequence(1) == sequence(1) != sequence(2)


def test_options_are_chosen_in_proportion_to_their_weights() -> None:
    counts = chosen("pose", ("a", "b", "c"), [*everywhere("pose", a=6.0, c=0.0)])
    assert counts["a"] == pytest.approx(2000 * 6 / 7, rel=0.05)
    assert (counts["a"] + counts["b"], counts["c"]) == (2000, 0)


def test_a_weight_for_the_state_and_turn_comes_first() -> None:
    weights = [*everywhere("pose", a=1000.0), ("", 2, "pose", "a", 500.0), ("Waiting", 2, "pose", "a", 0.0)]
    assert chosen("pose", ("a", "b"), weights, times=50) == {"b": 50}
    weights = [*everywhere("pose", a=1000.0), ("", 2, "pose", "a", 0.0), ("Waiting", 1, "pose", "b", 0.0)]
    assert chosen("pose", ("a", "b"), weights, times=50) == {"b": 50}


def test_goals_are_rare_and_acts_come_in_order_unless_weights_say_otherwise() -> None:
    assert 10 < chosen(GOAL, (NONE, "say"), ())["say"] < 100
    assert chosen(ACT, ("first", "second"), (), times=50) == {"first": 50}
    assert chosen(ACT, ("first", "second"), [*everywhere(ACT, second=1.0)])["second"] == pytest.approx(1000, rel=0.1)


def test_the_first_option_is_chosen_where_none_has_a_weight() -> None:
    assert chosen("pose", ("a", "b"), [*everywhere("pose", a=0.0, b=0.0)], times=5) == {"a": 5}
