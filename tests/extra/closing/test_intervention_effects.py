"""The effects of interventions, and what is told from chance."""

from __future__ import annotations

from math import comb

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.extra.closing.interactions import UNDISTURBED, Intervention
from pytest_hricdv.extra.closing.intervention_effects import (
    MAX_DEVIATIONS,
    PRIOR_EFFECTIVE,
    InterventionEffects,
    significance,
)
from pytest_hricdv.extra.closing.missing_conditions import (
    CharacterCondition,
    EffectCondition,
    effect_distance,
    is_met,
    missing_conditions,
)
from pytest_hricdv.extra.closing.outcome_model import OutcomeModel
from tests.extra.closing.test_outcome_model import LIGHT, PULL, PUSH, seen, usually_kept

KEPT = (("outcome", "kept"), ("reading", "00"))
GIVEN = (("outcome", "given"), ("reading", "10"))


def test_characters_are_missing_where_patterns_differ_and_the_whole_effect_only_where_none_does() -> None:
    assert missing_conditions(KEPT, GIVEN) == (CharacterCondition(3, 2, 0, "1"),)
    kept = (("outcome", "kept"), ("reading", "10"))
    assert missing_conditions(kept, GIVEN) == (EffectCondition(kept, GIVEN),)
    assert missing_conditions(GIVEN, GIVEN) == ()
    assert is_met(GIVEN, CharacterCondition(3, 2, 0, "1"))
    assert not is_met(KEPT, CharacterCondition(3, 2, 0, "1"))


def test_an_intervention_sets_a_bit_whatever_the_others_are() -> None:
    model = usually_kept()
    model.learn([seen(("1", "01"), (PUSH,), "11", "given"), seen(("1", "00"), (PULL,), "00", "kept")])
    assert set(InterventionEffects(model).chances(CharacterCondition(3, 2, 0, "1"), 3)) == {PUSH}


def test_what_comes_after_a_disturbed_interaction_counts_less() -> None:
    model = usually_kept()
    model.learn([seen(("1", "00"), (PUSH,), "10", "kept")])
    model.learn([seen(("1", "00"), (LIGHT,), "10", "kept")._replace(is_isolated=False)])
    chances = InterventionEffects(model).chances(CharacterCondition(3, 2, 0, "1"), 3)
    assert chances[PUSH] > chances[LIGHT] > 0.0


def test_what_comes_by_chance_is_not_ascribed_to_an_intervention() -> None:
    """A bit was set in one try of two; but where sensors err, that says little."""

    def chance(erring: int) -> float:
        model = OutcomeModel(2)
        model.learn([seen(("1", "00"), UNDISTURBED, "00", "kept")] * 20)
        model.learn([seen(("1", "00"), UNDISTURBED, "10", "kept")] * erring)
        model.learn([seen(("1", "00"), (PUSH,), reading, "kept") for reading in ("10", "00")])
        return InterventionEffects(model).chances(CharacterCondition(3, 2, 0, "1"), 3)[PUSH]

    assert chance(0) > 2 * chance(6) > 0.0


def test_effects_of_other_cross_products_are_not_compared() -> None:
    model = usually_kept()
    model.learn([seen(("1", "00"), (PUSH,), "10", "kept")._replace(effect=(("outcome", "given"),))])
    assert not InterventionEffects(model).chances(CharacterCondition(3, 2, 0, "1"), 3)


def test_nothing_is_known_where_nothing_was_run_undisturbed() -> None:
    model = OutcomeModel(2)
    model.learn([seen(("1", "00"), (PUSH,), "10", "kept"), seen(("1", "00"), UNDISTURBED, "0", "lost")][:1])
    assert not InterventionEffects(model).chances(CharacterCondition(3, 2, 0, "1"), 3)


def test_what_inverts_a_bit_one_way_probably_does_the_other_way_too() -> None:
    model = OutcomeModel(2)
    model.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 3)
    model.learn([seen(("1", "11"), (PUSH,), "01", "kept"), seen(("1", "11"), (PULL,), "11", "given")] * 2)
    chances = InterventionEffects(model).chances(CharacterCondition(3, 2, 0, "1"), 3)
    assert set(chances) == {PUSH}
    model.learn([seen(("1", "00"), UNDISTURBED, "00", "kept"), seen(("1", "00"), (PUSH,), "10", "kept")])
    assert InterventionEffects(model).chances(CharacterCondition(3, 2, 0, "1"), 3)[PUSH] > chances[PUSH]


def test_where_no_pattern_differs_what_brought_it_about_elsewhere_counts() -> None:
    model = usually_kept()
    model.learn([seen(("1", "away"), UNDISTURBED, "none", "silent"), seen(("1", "01"), (PUSH,), "none", "silent")])
    model.learn([seen(("1", "away"), (PULL,), "11", "given")])
    silent = (("outcome", "silent"), ("reading", "none"))
    (from_kept,) = missing_conditions((("outcome", "kept"), ("reading", "none")), silent)
    assert not InterventionEffects(model).chances(from_kept, 3)
    (from_pattern,) = (EffectCondition((("outcome", "kept"), ("reading", "00")), silent),)
    assert set(InterventionEffects(model).chances(from_pattern, 3)) == {PUSH}
    (from_silent,) = (EffectCondition(silent, (("outcome", "given"), ("reading", "11"))),)
    assert set(InterventionEffects(model).chances(from_silent, 3)) == {PULL}


def test_how_far_effects_are_apart() -> None:
    assert effect_distance((("110", "kept"),), (("111", "kept"),)) == 1 / 3
    assert effect_distance((("000", "kept"),), (("111", "given"),)) == 2.0
    assert effect_distance((("none", "kept"),), (("111", "kept"),)) == 1.0
    assert effect_distance((("111",), ("kept",)), (("111",), ("kept",))) == 0.0


def test_beside_another_one_an_intervention_may_not_do_what_it_does_alone() -> None:
    def after(*together: str) -> dict[Intervention, float]:
        model = usually_kept()
        model.learn([seen(("1", "away"), UNDISTURBED, "none", "silent"), seen(("1", "away"), (PULL,), "00", "kept")])
        model.learn([seen(("1", "00"), (intervention,), "10", "kept") for intervention in (PUSH, LIGHT)])
        model.learn([seen(("1", "away"), (PUSH, PULL), reading, "kept") for reading in together])
        return InterventionEffects(model).chances(CharacterCondition(3, 2, 0, "1"), 3)

    assert after()[PUSH] == after()[LIGHT]
    assert after("00", "00")[PUSH] < after("00", "00")[LIGHT]
    assert after("10", "10")[PUSH] > after("10", "10")[LIGHT]
    assert set(after("10")) == {PUSH, LIGHT}, "the other intervention has set nothing alone"


def test_what_masks_the_effect_of_another_one_has_brought_about_what_was_missing() -> None:
    model = OutcomeModel(2)
    model.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 3)
    model.learn([seen(("1", "11"), (intervention,), "01", "kept") for intervention in (PUSH, PULL)])
    before = InterventionEffects(model).chances(CharacterCondition(3, 2, 0, "1"), 3)[PUSH]
    model.learn([seen(("1", "11"), (PUSH, PULL), "11", "given")] * 2)
    assert InterventionEffects(model).chances(CharacterCondition(3, 2, 0, "1"), 3)[PUSH] > before


def test_of_combinations_with_the_same_effect_those_of_few_interventions_are_known() -> None:
    model = OutcomeModel(2)
    model.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 3)
    more = [(PUSH, Intervention(2, f"other{number}"), LIGHT) for number in range(MAX_DEVIATIONS)]
    model.learn([seen(("1", "11"), each, "01", "kept") for each in (*more, *more, (PUSH,))])
    nominal = model.nominal(("1", "11")) or ()
    assert (PUSH,) in [deviation.combination for deviation in InterventionEffects(model).deviations(nominal)]


def test_interventions_come_within_the_interaction() -> None:
    model, late = usually_kept(), Intervention(9, "push")
    model.learn([seen(("1", "00"), (late,), "10", "kept"), seen(("1", "01"), (late,), "11", "given")])
    assert set(InterventionEffects(model).chances(CharacterCondition(3, 2, 0, "1"), 3)) == {Intervention(3, "push")}


def test_a_disturbance_that_does_something_else_each_time_does_something_all_the_same() -> None:
    model = usually_kept()
    nominal = model.nominal(("1", "00"))
    assert nominal is not None
    for reading, outcome in (("10", "kept"), ("01", "kept"), ("11", "given"), ("none", "silent")):
        model.learn([seen(("1", "00"), (PUSH,), "10", "kept"), seen(("1", "00"), (PULL,), reading, outcome)])
        model.learn([seen(("1", "00"), (LIGHT,), "00", "kept"), seen(("2", "01"), (LIGHT,), "11", "given")])
    effects = InterventionEffects(model)
    assert effects.chance_of_any("pull", nominal) == effects.chance_of_any("push", nominal) > 0.7
    assert effects.chance_of_any("light", nominal) < 0.05


def test_what_stood_beside_an_effective_intervention_is_not_effective_itself() -> None:
    """Light set the bit once by chance, and often beside pushing, which does so by itself."""
    model = usually_kept()
    model.learn([seen(("1", "00"), (PUSH,), "10", "kept")] * 4)
    model.learn([seen(("1", "00"), (LIGHT,), reading, "kept") for reading in ("10", "00", "00", "00")])
    model.learn([seen(("1", "01"), (PUSH, LIGHT), "11", "kept")] * 20)
    chances = InterventionEffects(model).chances(CharacterCondition(3, 2, 0, "1"), 3)
    assert chances[PUSH] > 0.8
    assert chances.get(LIGHT, 0.0) < 0.2


def test_where_a_bit_is_often_set_with_any_disturbance_none_is_ascribed_it() -> None:
    def merit(others: int) -> float:
        model = usually_kept()
        model.learn([seen(("1", "00"), (PUSH,), "10", "kept")] * 3)
        interventions = [Intervention(1, f"other{number}") for number in range(others)]
        model.learn(
            [
                seen(("1", "00"), (intervention,), reading, "kept")
                for intervention in interventions
                for reading in ("10", "10", "00")
            ]
        )
        return InterventionEffects(model).chances(CharacterCondition(3, 2, 0, "1"), 3)[PUSH]

    assert merit(20) < 0.5 * merit(0)


def test_a_try_after_which_there_was_no_reading_promises_no_less() -> None:
    def promise(reading: str) -> float:
        model = usually_kept()
        model.learn([seen(("1", "00"), (PUSH,), reading, "kept")] * 5)
        return InterventionEffects(model).chances_of_change(["push"], CharacterCondition(3, 2, 0, "1"))["push"]

    assert promise("none") == 0.5
    assert promise("00") < 0.2


RATES = st.floats(0.01, 0.5)


@given(RATES, st.integers(0, 20), st.integers(0, 20))
def test_it_is_the_rule_of_bayes(by_chance: float, came: int, vain: int) -> None:
    """With a uniform rate, each number of successes among so many tries is equally likely."""
    tries = came + vain
    effect = PRIOR_EFFECTIVE / (tries + 1)
    chance = (1 - PRIOR_EFFECTIVE) * comb(tries, came) * by_chance**came * (1 - by_chance) ** vain
    assert significance(came, tries, by_chance) == pytest.approx(effect / (effect + chance))


def test_without_tries_it_is_what_is_expected_of_anything() -> None:
    assert significance(0.0, 0.0, 0.05) == pytest.approx(PRIOR_EFFECTIVE)


def test_one_result_of_a_sensor_that_errs_says_little_after_some_tries_in_vain() -> None:
    chances = [significance(1.0, tries, 0.05) for tries in (1.0, 2.0, 4.0, 8.0)]
    assert chances == sorted(chances, reverse=True)
    assert chances[0] > 0.5 > 0.2 > chances[2]
    assert significance(4.0, 8.0, 0.05) > 0.9


def test_very_many_tries_are_no_error() -> None:
    assert significance(1e5, 1e5, 0.01) == pytest.approx(1.0)
    assert significance(1e3, 1e5, 0.01) < PRIOR_EFFECTIVE
