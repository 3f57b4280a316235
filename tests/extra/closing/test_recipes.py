"""What is learned of treatments, from which the next ones are chosen."""

from __future__ import annotations

from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.extra.closing.interactions import UNDISTURBED, Dose, Goal, Interaction, Treatment
from pytest_hricdv.extra.closing.recipes import HOPE, Recipes

PUSH, PULL, LIGHT = Dose(1, "push"), Dose(2, "pull"), Dose(1, "light")
GIVEN = ("outcome", "given")


def seen(planned: Bin, treatment: Treatment, reading: str, outcome: str) -> Interaction:
    """An interaction with a reading, of another cross product, and an outcome."""
    return Interaction(planned, treatment, (("outcome", outcome), ("reading", reading)))


def usually_kept() -> Recipes:
    """Without disturbances, whoever stands as "00" or "01" is given nothing."""
    recipes = Recipes(2)
    recipes.learn([seen((legs, pose), UNDISTURBED, pose, "kept") for legs in "12" for pose in ("00", "01")] * 4)
    return recipes


def test_what_led_to_a_goal_is_done_again_where_the_rest_is_alike() -> None:
    recipes = usually_kept()
    recipes.learn([seen(("1", "01"), (PUSH,), "11", "given")])
    recipe = recipes.best(("2", "01"), GIVEN, commands=3)
    assert recipe is not None
    assert recipe.treatment == (PUSH,)
    assert recipe.chance > HOPE


def test_what_fails_again_and_again_is_expected_no_more() -> None:
    recipes = usually_kept()
    recipes.learn([seen(("1", "01"), (PUSH,), "11", "given")])
    recipes.learn([seen(("2", "01"), (PUSH,), "01", "kept")] * 10)
    assert recipes.chance(("2", "01"), (PUSH,), GIVEN) < 0.1


def test_where_treatments_from_elsewhere_have_failed_others_are_trusted_less() -> None:
    def after(aims: tuple[Goal, ...]) -> Recipes:
        recipes = usually_kept()
        recipes.learn([seen(("1", "01"), (dose,), "11", "given") for dose in (PUSH, PULL, LIGHT)])
        recipes.learn([seen(("1", "00"), (dose,), "00", "kept")._replace(aims=aims) for dose in (PUSH, PULL)])
        return recipes

    failed, not_aimed = after((GIVEN,)), after(())
    for planned, factor in ((("2", "00"), 0.5), (("2", "01"), 1.0)):  # in the second, the same usually comes
        recipe, other = (each.best(planned, GIVEN, commands=3) for each in (failed, not_aimed))
        assert recipe is not None
        assert other is not None
        assert recipe.chance <= factor * other.chance
    assert recipe.chance == other.chance > HOPE


def test_a_coordinate_that_makes_no_difference_is_learned_to_be_alike() -> None:
    recipes, outcome = Recipes(2), {"00": "kept", "01": "silent"}
    recipes.learn([seen((legs, pose), UNDISTURBED, pose, outcome[pose]) for legs in "123" for pose in ("00", "01")] * 5)
    recipes.learn([seen(("1", "00"), (PUSH,), "11", "given")])
    other_legs = recipes.chance(("2", "00"), (PUSH,), GIVEN)
    other_pose = recipes.chance(("1", "01"), (PUSH,), GIVEN)
    assert other_legs > 0.6 > 0.3 > other_pose


def test_what_comes_without_a_disturbance_is_no_merit_of_one() -> None:
    recipes = Recipes(2)
    recipes.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 5)
    recipes.learn([seen(("1", "11"), (LIGHT,), "11", "given")])
    assert recipes.best(("1", "01"), GIVEN, commands=3) is None


def test_a_part_of_a_recipe_may_be_one() -> None:
    recipes = usually_kept()
    recipes.learn([seen(("1", "00"), (PUSH, PULL), "11", "given")])
    recipes.learn([seen(("1", "01"), (PUSH, PULL), "01", "kept")] * 5)
    recipe = recipes.best(("1", "01"), GIVEN, commands=3)
    assert recipe is not None
    assert len(recipe.treatment) == 1


def test_a_treatment_is_made_to_fit_into_a_shorter_interaction() -> None:
    recipes = usually_kept()
    recipes.learn([seen(("1", "00"), (PULL,), "11", "given")])
    recipe = recipes.best(("2", "00"), GIVEN, commands=1)
    assert recipe is not None
    assert recipe.treatment == (PULL._replace(place=1),)
    assert recipe.chance > HOPE


def test_what_usually_comes_where_it_was_never_run_is_taken_from_what_is_alike_and_only_from_that() -> None:
    recipes = usually_kept()
    assert recipes.usual(("3", "00")) == recipes.usual(("1", "00"))
    assert recipes.usual(("3", "11")) is None


def test_what_a_longer_interaction_has_shown_counts_until_the_shorter_one_was_tried() -> None:
    recipes = usually_kept()
    recipes.learn([seen(("1", "00"), (PULL,), "11", "given")] * 4)
    before = recipes.best(("2", "00"), GIVEN, commands=1)
    recipes.learn([seen(("3", "00"), (PULL._replace(place=1),), "00", "kept")] * 2)
    after = recipes.best(("2", "00"), GIVEN, commands=1)
    assert before is not None
    assert after is not None
    assert after.chance < 0.4 * before.chance


def test_what_comes_of_nothing_after_a_disturbed_interaction_says_nothing_of_undisturbed_ones() -> None:
    """A disturbance may last: a leg that is late is missing in the next turn."""
    recipes = usually_kept()
    before = recipes.chance(("1", "00"), UNDISTURBED, ("outcome", "kept"))
    recipes.learn([seen(("1", "00"), UNDISTURBED, "none", "silent")._replace(is_clean=False)] * 9)
    assert recipes.chance(("1", "00"), UNDISTURBED, ("outcome", "kept")) == before
    assert recipes.usual(("1", "00")) == (("outcome", "kept"), ("reading", "00"))
