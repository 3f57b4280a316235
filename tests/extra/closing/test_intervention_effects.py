"""The effects of interventions, and what is told from chance."""

from __future__ import annotations

from math import comb

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.extra.closing.interactions import UNDISTURBED, Intervention
from pytest_hricdv.extra.closing.intervention_effects import (
    PRIOR_EFFECTIVE,
    InterventionEffects,
    significance,
)
from pytest_hricdv.extra.closing.missing_conditions import (
    CharacterCondition,
    EffectCondition,
    effect_distance,
    find_missing,
    is_met,
)
from pytest_hricdv.extra.closing.outcome_model import OutcomeModel
from tests.extra.closing.test_outcome_model import PULL, PUSH, seen, usually_kept

KEPT = (("outcome", "kept"), ("reading", "00"))
GIVEN = (("outcome", "given"), ("reading", "10"))


def test_characters_are_missing_where_patterns_differ_and_the_whole_effect_only_where_none_does() -> None:
    assert find_missing(KEPT, GIVEN) == (CharacterCondition(3, 2, 0, "1"),)
    kept = (("outcome", "kept"), ("reading", "10"))
    assert find_missing(kept, GIVEN) == (EffectCondition(kept, GIVEN),)
    assert find_missing(GIVEN, GIVEN) == ()
    assert is_met(GIVEN, CharacterCondition(3, 2, 0, "1"))
    assert not is_met(KEPT, CharacterCondition(3, 2, 0, "1"))


def test_an_intervention_sets_a_bit_whatever_the_others_are() -> None:
    model = usually_kept()
    model.learn([seen(("1", "01"), (PUSH,), "11", "given"), seen(("1", "00"), (PULL,), "00", "kept")])
    assert set(InterventionEffects(model).chances(CharacterCondition(3, 2, 0, "1"), 3)) == {PUSH}


def test_effects_of_other_cross_products_are_not_compared() -> None:
    model = usually_kept()
    model.learn([seen(("1", "00"), (PUSH,), "10", "kept")._replace(effect=(("outcome", "given"),))])
    assert not InterventionEffects(model).chances(CharacterCondition(3, 2, 0, "1"), 3)


def test_how_far_effects_are_apart() -> None:
    assert effect_distance((("110", "kept"),), (("111", "kept"),)) == 1 / 3
    assert effect_distance((("000", "kept"),), (("111", "given"),)) == 2.0
    assert effect_distance((("none", "kept"),), (("111", "kept"),)) == 1.0
    assert effect_distance((("111",), ("kept",)), (("111",), ("kept",))) == 0.0


def test_what_masks_the_effect_of_another_one_has_brought_about_what_was_missing() -> None:
    model = OutcomeModel(2)
    model.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 3)
    model.learn([seen(("1", "11"), (intervention,), "01", "kept") for intervention in (PUSH, PULL)])
    before = InterventionEffects(model).chances(CharacterCondition(3, 2, 0, "1"), 3)[PUSH]
    model.learn([seen(("1", "11"), (PUSH, PULL), "11", "given")] * 2)
    assert InterventionEffects(model).chances(CharacterCondition(3, 2, 0, "1"), 3)[PUSH] > before


def test_interventions_come_within_the_interaction() -> None:
    model, late = usually_kept(), Intervention(9, "push")
    model.learn([seen(("1", "00"), (late,), "10", "kept"), seen(("1", "01"), (late,), "11", "given")])
    assert set(InterventionEffects(model).chances(CharacterCondition(3, 2, 0, "1"), 3)) == {Intervention(3, "push")}


RATES = st.floats(0.01, 0.5)


@given(RATES, st.integers(0, 20), st.integers(0, 20))
def test_it_is_the_rule_of_bayes(by_chance: float, came: int, vain: int) -> None:
    """With a uniform rate, each number of successes among so many tries is equally likely."""
    tries = came + vain
    effect = PRIOR_EFFECTIVE / (tries + 1)
    chance = (1 - PRIOR_EFFECTIVE) * comb(tries, came) * by_chance**came * (1 - by_chance) ** vain
    assert significance(came, tries, by_chance) == pytest.approx(effect / (effect + chance))


def test_very_many_tries_are_no_error() -> None:
    assert significance(1e5, 1e5, 0.01) == pytest.approx(1.0)
    assert significance(1e3, 1e5, 0.01) < PRIOR_EFFECTIVE
