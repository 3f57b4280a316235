"""Treatments that are put together from what is known."""

from __future__ import annotations

from collections import Counter

from pytest_hricdv.extra.closing.compositions import MOST_DOSES, Compositions
from pytest_hricdv.extra.closing.interactions import UNDISTURBED, Dose
from pytest_hricdv.extra.closing.recipes import Recipes, fitted
from pytest_hricdv.generate.rng import make_rng
from tests.extra.closing.test_recipes import GIVEN, LIGHT, PULL, PUSH, seen, usually_kept


def each_mends_one_letter() -> Recipes:
    """Pushing and pulling each mend one of two letters; light mends none, but for a chance."""
    recipes = usually_kept()
    recipes.learn([seen(("1", "11"), UNDISTURBED, "11", "given")])
    recipes.learn([seen(("1", "00"), (PUSH,), "10", "kept"), seen(("1", "00"), (PULL,), "01", "kept")] * 2)
    recipes.learn([seen(("1", "00"), (LIGHT,), "00", "kept")] * 5)
    return recipes


def test_doses_that_each_mend_a_letter_are_put_together() -> None:
    recipe = Compositions(each_mends_one_letter()).drawn(("1", "00"), GIVEN, 3, make_rng("together"))
    assert recipe is not None
    assert recipe.treatment == (PUSH, PULL)


def test_what_is_put_together_and_fails_is_expected_no_more() -> None:
    recipes = each_mends_one_letter()
    first = Compositions(recipes).drawn(("1", "00"), GIVEN, 3, make_rng("together"))
    recipes.learn([seen(("1", "00"), (PUSH, PULL), "00", "kept")] * 8)
    last = Compositions(recipes).drawn(("1", "00"), GIVEN, 3, make_rng("together"))
    assert first is not None
    assert last is not None
    assert first.chance > 2 * last.chance


def test_what_is_lacking_after_something_makes_it_look_like_another_one_is_mended() -> None:
    recipes = each_mends_one_letter()
    recipes.learn([seen(("1", "away"), UNDISTURBED, "none", "silent")] * 2)
    recipes.learn([seen(("1", "away"), (LIGHT,), "01", "kept")] * 2)
    recipe = Compositions(recipes).drawn(("1", "away"), GIVEN, 3, make_rng("away"))
    assert recipe is not None
    assert recipe.treatment == (LIGHT, PUSH)


def test_what_was_mended_in_vain_is_put_together_less_and_what_was_not_mended_does_not_count() -> None:
    recipes = each_mends_one_letter()
    recipes.learn([seen(("1", "away"), UNDISTURBED, "none", "silent")] * 2)
    recipes.learn([seen(("1", "away"), (LIGHT,), "01", "kept")] * 2)
    before = Compositions(recipes).drawn(("1", "away"), GIVEN, 3, make_rng("away"))
    other = seen(("1", "away"), (LIGHT, PULL), "01", "kept")._replace(aims=(GIVEN,))
    recipes.learn([other] * 3)
    same = Compositions(recipes).drawn(("1", "away"), GIVEN, 3, make_rng("away"))
    recipes.learn([seen(("1", "away"), (LIGHT, PUSH), "11", "kept")._replace(aims=(GIVEN,))] * 3)
    after = Compositions(recipes).drawn(("1", "away"), GIVEN, 3, make_rng("away"))
    assert before is not None
    assert same is not None
    assert after is not None
    assert same.chance > 0.9 * before.chance
    assert after.chance < 0.6 * before.chance


def test_what_is_put_together_around_many_doses_loses_some_of_these() -> None:
    recipes = each_mends_one_letter()
    many = tuple(Dose(1, f"other{number}") for number in range(MOST_DOSES))
    recipes.learn([seen(("1", "away"), UNDISTURBED, "none", "silent")] * 2)
    recipes.learn([seen(("1", "away"), many, "01", "kept")] * 4)
    recipe = Compositions(recipes).drawn(("1", "away"), GIVEN, 3, make_rng("many"))
    assert recipe is not None
    assert PUSH in recipe.treatment
    assert set(recipe.treatment) < {PUSH, *many}
    assert len(recipe.treatment) == MOST_DOSES


def test_where_no_dose_has_mended_what_is_lacking_nothing_is_known() -> None:
    assert Compositions(usually_kept()).drawn(("1", "00"), GIVEN, 3, make_rng("unknown")) is None


def test_disturbances_that_change_what_is_lacking_promise_most_and_those_that_do_not_less_than_unknown_ones() -> None:
    recipes = usually_kept()
    recipes.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    recipes.learn([seen(("1", "11"), (PUSH,), "01", "kept"), seen(("1", "11"), (LIGHT,), "10", "kept")])
    promise = Compositions(recipes).promise(("push", "pull", "light"), ("1", "01"), GIVEN, commands=3)
    assert promise["push"] > promise["pull"] > promise["light"]


def test_new_doses_are_for_the_letters_that_no_known_one_mends() -> None:
    recipes = usually_kept()
    recipes.learn([seen(("1", "00"), (PUSH,), "10", "kept")] * 9)
    recipes.learn([seen(("2", "00"), (PULL,), "00", "kept")])
    recipes.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    promise = Compositions(recipes).promise(("push", "pull", "light"), ("1", "00"), GIVEN, commands=3)
    assert max(promise, key=lambda name: promise[name]) == "light"


def test_what_one_dose_changes_another_one_may_hide() -> None:
    recipes = usually_kept()
    recipes.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    recipes.learn([seen(("1", "11"), (PULL,), "10", "kept"), seen(("2", "01"), (PUSH,), "01", "kept")] * 3)
    assert Compositions(recipes).masked(("1", "11"), 3, make_rng("hidden")) is None
    recipes.learn([seen(("2", "00"), (PUSH,), "01", "kept")] * 3)
    assert Compositions(recipes).masked(("1", "11"), 3, make_rng("hidden")) == (PUSH, PULL)
    assert Compositions(recipes).masked(("3", "11"), 3, make_rng("hidden")) == (PUSH, PULL)


def test_what_is_still_lacking_when_something_was_hidden_is_mended_too() -> None:
    recipes = each_mends_one_letter()
    recipes.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    recipes.learn([seen(("1", "11"), (LIGHT,), "01", "kept")] * 3)
    assert Compositions(recipes).masked(("1", "11"), 3, make_rng("hidden")) == fitted((LIGHT, PUSH), 3)
    recipes.learn([seen(("1", "11"), fitted((LIGHT, PUSH), 3), "10", "kept")])
    assert Compositions(recipes).masked(("1", "11"), 3, make_rng("hidden")) == fitted((LIGHT, PUSH, PULL), 3)
    recipes.learn([seen(("1", "11"), fitted((LIGHT, PUSH, PULL), 3), "11", "given")])
    assert Compositions(recipes).masked(("1", "11"), 3, make_rng("hidden")) == fitted((LIGHT, PUSH, PULL), 3)


def test_what_leads_to_a_goal_is_tried_beside_what_changes_it_where_it_is_usual() -> None:
    recipes = each_mends_one_letter()
    recipes.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    recipes.learn([seen(("1", "11"), (LIGHT,), "01", "kept")] * 3)
    assert Compositions(recipes).beside(("1", "00"), GIVEN, 3, make_rng("beside")) is None
    recipes.learn([seen(("1", "00"), (PUSH, PULL), "11", "given")] * 3)
    assert Compositions(recipes).beside(("1", "00"), GIVEN, 3, make_rng("beside")) == fitted((PUSH, PULL, LIGHT), 3)


def test_what_was_lacking_when_something_was_tried_beside_a_recipe_is_mended_too() -> None:
    recipes = each_mends_one_letter()
    shout = Dose(1, "shout")
    recipes.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    recipes.learn([seen(("1", "11"), (LIGHT,), "01", "kept"), seen(("1", "00"), (shout,), "10", "kept")] * 3)
    recipes.learn([seen(("1", "00"), (PUSH, PULL), "11", "given")] * 3)
    recipes.learn([seen(("1", "00"), fitted((PUSH, PULL, LIGHT), 3), "01", "kept")])
    found = Compositions(recipes).beside(("1", "00"), GIVEN, 3, make_rng("beside"))
    assert found == fitted((PUSH, PULL, LIGHT, shout), 3)


def test_what_makes_something_quite_different_of_an_interaction_cannot_be_tried_beside_a_recipe() -> None:
    recipes = each_mends_one_letter()
    recipes.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    recipes.learn([seen(("1", "11"), (LIGHT,), "none", "silent"), seen(("1", "00"), (PUSH, PULL), "11", "given")] * 3)
    assert Compositions(recipes).beside(("1", "00"), GIVEN, 3, make_rng("beside")) is None


def pushed_and_pulled(tries: int, came: str) -> int:
    """How often of 100 times pushing is to hide pulling, after so many tries in which this came; it may hide light."""
    recipes = usually_kept()
    recipes.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    for dose in (PULL, LIGHT):
        recipes.learn([seen(("1", "11"), (dose,), "10", "kept")] * 3)
    recipes.learn([seen(("2", "00"), (PUSH,), "01", "kept")] * 30)
    recipes.learn([seen(("1", "11"), (PUSH, PULL), came, "given")] * tries)
    rng = make_rng("rare")
    return sum(Compositions(recipes).masked(("1", "11"), 3, rng) == (PUSH, PULL) for _ in range(100))


def test_what_was_rarely_combined_is_rather_hidden() -> None:
    assert pushed_and_pulled(9, "11") < 0.5 * pushed_and_pulled(0, "11")


def test_what_was_hidden_and_nothing_came_of_it_is_hidden_less_also_in_other_ways() -> None:
    def pulled(tries: int) -> int:
        recipes = usually_kept()
        recipes.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
        recipes.learn([seen(("1", "11"), (dose,), "10", "kept") for dose in (PULL, LIGHT)] * 3)
        recipes.learn([seen(("2", "00"), (PUSH,), "01", "kept")] * 30)
        recipes.learn([seen(("1", "11"), (Dose(1, f"other{number}"), PULL), "11", "given") for number in range(tries)])
        rng = make_rng("nothing")
        return sum(PULL in (Compositions(recipes).masked(("1", "11"), 3, rng) or ()) for _ in range(100))

    assert pulled(9) < 0.5 * pulled(0)


def test_a_disturbance_of_which_many_doses_are_known_is_hidden_no_more_often_than_another() -> None:
    """Nine doses of light change what one of pulling does; pushing hides both."""
    recipes = usually_kept()
    recipes.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    lights = [LIGHT._replace(values=(("lux", 0.1 * number),)) for number in range(9)]
    recipes.learn([seen(("1", "11"), (dose,), "10", "kept") for dose in (*[PULL] * 9, *lights)])
    recipes.learn([seen(("2", "00"), (PUSH,), "01", "kept")] * 30)
    rng = make_rng("alike")
    masked = [Compositions(recipes).masked(("1", "11"), 3, rng) or () for _ in range(100)]
    pairs = Counter(frozenset(dose.name for dose in treatment) for treatment in masked)
    assert pairs[frozenset({"push", "light"})] < 2 * pairs[frozenset({"push", "pull"})]


def test_tries_in_which_something_else_went_wrong_do_not_count() -> None:
    assert pushed_and_pulled(9, "none") > 0.7 * pushed_and_pulled(0, "none")


def test_what_changes_a_letter_where_something_else_is_planned_is_hidden_too() -> None:
    recipes = usually_kept()
    recipes.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    recipes.learn([seen(("2", "01"), (PULL,), "00", "kept"), seen(("2", "00"), (PUSH,), "01", "kept")] * 3)
    assert Compositions(recipes).masked(("1", "11"), 3, make_rng("hidden")) == (PUSH, PULL)


def test_what_did_something_is_tried_without_one_of_its_doses() -> None:
    recipes = usually_kept()
    recipes.learn([seen(("1", "00"), (LIGHT, PUSH, PULL), "11", "given")] * 2)
    recipes.learn([seen(("1", "00"), (LIGHT, PUSH), "10", "kept")])
    compositions = Compositions(recipes)
    found = {compositions.reduced(("2", "00"), 3, make_rng(str(number))) for number in range(20)}
    assert found == {(PUSH, PULL), (LIGHT, PULL), (LIGHT,), (PUSH,)}
    assert Compositions(usually_kept()).reduced(("2", "00"), 3, make_rng("none")) is None


def test_what_has_to_be_moved_to_fit_is_not_expected_to_do_the_same_once_it_was_tried() -> None:
    recipes = usually_kept()
    recipes.learn([seen(("1", "00"), (PULL,), "11", "given")] * 4)
    before = Compositions(recipes).drawn(("1", "00"), GIVEN, 1, make_rng("moved"))
    recipes.learn([seen(("2", "00"), fitted((PULL,), 1), "00", "kept")])
    after = Compositions(recipes).drawn(("1", "00"), GIVEN, 1, make_rng("moved"))
    assert before is not None
    assert before.treatment == fitted((PULL,), 1)
    assert after is None or after.chance < 0.3 * before.chance
