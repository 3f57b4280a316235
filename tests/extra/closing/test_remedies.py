"""What doses mend."""

from __future__ import annotations

from pytest_hricdv.extra.closing.interactions import UNDISTURBED, Dose
from pytest_hricdv.extra.closing.lack import Letter, Whole, apart, has, lacking
from pytest_hricdv.extra.closing.recipes import Recipes
from pytest_hricdv.extra.closing.remedies import MOST_SHIFTS, Remedies
from tests.extra.closing.test_recipes import LIGHT, PULL, PUSH, seen, usually_kept

KEPT = (("outcome", "kept"), ("reading", "00"))
GIVEN = (("outcome", "given"), ("reading", "10"))


def test_letters_are_lacking_where_patterns_differ_and_all_together_only_where_none_does() -> None:
    assert lacking(KEPT, GIVEN) == (Letter(3, 2, 0, "1"),)
    kept = (("outcome", "kept"), ("reading", "10"))
    assert lacking(kept, GIVEN) == (Whole(kept, GIVEN),)
    assert lacking(GIVEN, GIVEN) == ()
    assert has(GIVEN, Letter(3, 2, 0, "1"))
    assert not has(KEPT, Letter(3, 2, 0, "1"))


def test_a_dose_mends_a_letter_whatever_the_others_are() -> None:
    recipes = usually_kept()
    recipes.learn([seen(("1", "01"), (PUSH,), "11", "given"), seen(("1", "00"), (PULL,), "00", "kept")])
    assert set(Remedies(recipes).against(Letter(3, 2, 0, "1"), 3)) == {PUSH}


def test_what_comes_after_a_disturbed_interaction_counts_less() -> None:
    recipes = usually_kept()
    recipes.learn([seen(("1", "00"), (PUSH,), "10", "kept")])
    recipes.learn([seen(("1", "00"), (LIGHT,), "10", "kept")._replace(is_clean=False)])
    chances = Remedies(recipes).against(Letter(3, 2, 0, "1"), 3)
    assert chances[PUSH] > chances[LIGHT] > 0.0


def test_what_comes_by_chance_is_no_merit_of_a_dose() -> None:
    """Both mended a letter in one try of two; but where sensors err, that says little."""

    def chance(erring: int) -> float:
        recipes = Recipes(2)
        recipes.learn([seen(("1", "00"), UNDISTURBED, "00", "kept")] * 20)
        recipes.learn([seen(("1", "00"), UNDISTURBED, "10", "kept")] * erring)
        recipes.learn([seen(("1", "00"), (PUSH,), reading, "kept") for reading in ("10", "00")])
        return Remedies(recipes).against(Letter(3, 2, 0, "1"), 3)[PUSH]

    assert chance(0) > 2 * chance(6) > 0.0


def test_effects_of_other_cross_products_are_not_compared() -> None:
    recipes = usually_kept()
    recipes.learn([seen(("1", "00"), (PUSH,), "10", "kept")._replace(effect=(("outcome", "given"),))])
    assert not Remedies(recipes).against(Letter(3, 2, 0, "1"), 3)


def test_nothing_is_known_where_nothing_was_run_undisturbed() -> None:
    recipes = Recipes(2)
    recipes.learn([seen(("1", "00"), (PUSH,), "10", "kept"), seen(("1", "00"), UNDISTURBED, "0", "lost")][:1])
    assert not Remedies(recipes).against(Letter(3, 2, 0, "1"), 3)


def test_what_makes_the_contrary_of_a_letter_probably_mends_it_too() -> None:
    recipes = Recipes(2)
    recipes.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 3)
    recipes.learn([seen(("1", "11"), (PUSH,), "01", "kept"), seen(("1", "11"), (PULL,), "11", "given")] * 2)
    chances = Remedies(recipes).against(Letter(3, 2, 0, "1"), 3)
    assert set(chances) == {PUSH}
    recipes.learn([seen(("1", "00"), UNDISTURBED, "00", "kept"), seen(("1", "00"), (PUSH,), "10", "kept")])
    assert Remedies(recipes).against(Letter(3, 2, 0, "1"), 3)[PUSH] > chances[PUSH]


def test_where_no_pattern_differs_what_has_mended_it_elsewhere_does() -> None:
    recipes = usually_kept()
    recipes.learn([seen(("1", "away"), UNDISTURBED, "none", "silent"), seen(("1", "01"), (PUSH,), "none", "silent")])
    recipes.learn([seen(("1", "away"), (PULL,), "11", "given")])
    silent = (("outcome", "silent"), ("reading", "none"))
    (from_kept,) = lacking((("outcome", "kept"), ("reading", "none")), silent)
    assert not Remedies(recipes).against(from_kept, 3)
    (from_pattern,) = (Whole((("outcome", "kept"), ("reading", "00")), silent),)
    assert set(Remedies(recipes).against(from_pattern, 3)) == {PUSH}
    (from_silent,) = (Whole(silent, (("outcome", "given"), ("reading", "11"))),)
    assert set(Remedies(recipes).against(from_silent, 3)) == {PULL}


def test_how_far_effects_are_apart() -> None:
    assert apart((("110", "kept"),), (("111", "kept"),)) == 1 / 3
    assert apart((("000", "kept"),), (("111", "given"),)) == 2.0
    assert apart((("none", "kept"),), (("111", "kept"),)) == 1.0
    assert apart((("111",), ("kept",)), (("111",), ("kept",))) == 0.0


def test_with_another_dose_a_dose_may_not_do_what_it_does_alone() -> None:
    def after(*together: str) -> dict[Dose, float]:
        recipes = usually_kept()
        recipes.learn([seen(("1", "away"), UNDISTURBED, "none", "silent"), seen(("1", "away"), (PULL,), "00", "kept")])
        recipes.learn([seen(("1", "00"), (dose,), "10", "kept") for dose in (PUSH, LIGHT)])
        recipes.learn([seen(("1", "away"), (PUSH, PULL), reading, "kept") for reading in together])
        return Remedies(recipes).against(Letter(3, 2, 0, "1"), 3)

    assert after()[PUSH] == after()[LIGHT]
    assert after("00", "00")[PUSH] < after("00", "00")[LIGHT]
    assert after("10", "10")[PUSH] > after("10", "10")[LIGHT]
    assert set(after("10")) == {PUSH, LIGHT}, "the other dose has mended nothing alone"


def test_what_hides_the_effect_of_another_dose_has_mended_it() -> None:
    recipes = Recipes(2)
    recipes.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 3)
    recipes.learn([seen(("1", "11"), (dose,), "01", "kept") for dose in (PUSH, PULL)])
    before = Remedies(recipes).against(Letter(3, 2, 0, "1"), 3)[PUSH]
    recipes.learn([seen(("1", "11"), (PUSH, PULL), "11", "given")] * 2)
    assert Remedies(recipes).against(Letter(3, 2, 0, "1"), 3)[PUSH] > before


def test_of_treatments_with_the_same_effect_those_of_few_doses_are_known() -> None:
    recipes = Recipes(2)
    recipes.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 3)
    more = [(PUSH, Dose(2, f"other{number}"), LIGHT) for number in range(MOST_SHIFTS)]
    recipes.learn([seen(("1", "11"), each, "01", "kept") for each in (*more, *more, (PUSH,))])
    usual = recipes.usual(("1", "11")) or ()
    assert (PUSH,) in [shift.treatment for shift in Remedies(recipes).shifts(usual)]


def test_doses_come_within_the_interaction() -> None:
    recipes, late = usually_kept(), Dose(9, "push")
    recipes.learn([seen(("1", "00"), (late,), "10", "kept"), seen(("1", "01"), (late,), "11", "given")])
    assert set(Remedies(recipes).against(Letter(3, 2, 0, "1"), 3)) == {Dose(3, "push")}


def test_a_disturbance_that_does_something_else_each_time_does_something_all_the_same() -> None:
    recipes = usually_kept()
    usual = recipes.usual(("1", "00"))
    assert usual is not None
    for reading, outcome in (("10", "kept"), ("01", "kept"), ("11", "given"), ("none", "silent")):
        recipes.learn([seen(("1", "00"), (PUSH,), "10", "kept"), seen(("1", "00"), (PULL,), reading, outcome)])
        recipes.learn([seen(("1", "00"), (LIGHT,), "00", "kept"), seen(("2", "01"), (LIGHT,), "11", "given")])
    remedies = Remedies(recipes)
    assert remedies.disturbing("pull", usual) == remedies.disturbing("push", usual) > 0.7
    assert remedies.disturbing("light", usual) < 0.05


def test_what_stood_beside_a_remedy_is_none() -> None:
    """Light mended the letter once by chance, and often beside pushing, which does so by itself."""
    recipes = usually_kept()
    recipes.learn([seen(("1", "00"), (PUSH,), "10", "kept")] * 4)
    recipes.learn([seen(("1", "00"), (LIGHT,), reading, "kept") for reading in ("10", "00", "00", "00")])
    recipes.learn([seen(("1", "01"), (PUSH, LIGHT), "11", "kept")] * 20)
    chances = Remedies(recipes).against(Letter(3, 2, 0, "1"), 3)
    assert chances[PUSH] > 0.8
    assert chances.get(LIGHT, 0.0) < 0.2


def test_where_a_letter_often_comes_with_any_disturbance_that_is_no_merit_of_one() -> None:
    def merit(others: int) -> float:
        recipes = usually_kept()
        recipes.learn([seen(("1", "00"), (PUSH,), "10", "kept")] * 3)
        doses = [Dose(1, f"other{number}") for number in range(others)]
        recipes.learn([seen(("1", "00"), (dose,), reading, "kept") for dose in doses for reading in ("10", "10", "00")])
        return Remedies(recipes).against(Letter(3, 2, 0, "1"), 3)[PUSH]

    assert merit(20) < 0.5 * merit(0)


def test_a_try_after_which_nothing_like_the_letter_was_there_promises_no_less() -> None:
    def promise(reading: str) -> float:
        recipes = usually_kept()
        recipes.learn([seen(("1", "00"), (PUSH,), reading, "kept")] * 5)
        return Remedies(recipes).promise(["push"], Letter(3, 2, 0, "1"))["push"]

    assert promise("none") == 0.5
    assert promise("00") < 0.2
