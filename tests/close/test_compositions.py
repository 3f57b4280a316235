"""Treatments that are put together from what is known."""

from __future__ import annotations

from pytest_hricdv.close.compositions import Compositions, apart
from pytest_hricdv.close.interactions import UNDISTURBED
from pytest_hricdv.close.recipes import Recipes
from tests.close.test_recipes import GIVEN, LIGHT, PULL, PUSH, seen, usually_kept


def test_what_comes_nearer_alone_is_put_together() -> None:
    recipes = usually_kept()
    recipes.learn([seen(("1", "11"), UNDISTURBED, "11", "given")])
    recipes.learn([seen(("1", "00"), (PUSH,), "10", "kept"), seen(("1", "00"), (PULL,), "01", "kept")])
    recipes.learn([seen(("1", "00"), (LIGHT,), "00", "kept")] * 5)
    assert Compositions(recipes).of(("1", "00"), GIVEN, commands=3)[0] == (PUSH, PULL)
    assert Compositions(recipes).helpful_names(GIVEN)["light"] == 0.0
    recipes.learn([seen(("1", "00"), (PUSH, PULL), "00", "kept")])
    assert (PUSH, PULL) not in Compositions(recipes).of(("1", "00"), GIVEN, commands=3)


def test_what_leads_to_the_goal_from_elsewhere_is_done_where_something_makes_it_look_like_that() -> None:
    recipes = Recipes(2)
    recipes.learn([seen(("1", "away"), UNDISTURBED, "none", "silent"), seen(("1", "00"), UNDISTURBED, "00", "kept")])
    recipes.learn([seen(("1", "away"), (PUSH,), "00", "kept")])
    recipes.learn([seen(("1", "00"), (PULL,), "none", "late")])
    assert (PUSH, PULL) in Compositions(recipes).of(("1", "away"), ("outcome", "late"), commands=3)


def test_of_a_goal_that_was_never_seen_nothing_is_known() -> None:
    assert Compositions(usually_kept()).of(("1", "00"), GIVEN, commands=3) == []


def test_texts_of_one_length_are_compared_as_patterns_of_bits() -> None:
    assert apart((("110", "kept"),), (("111", "kept"),)) == 1 / 3
    assert apart((("000", "kept"),), (("111", "given"),)) == 2.0
    assert apart((("none", "kept"),), (("111", "kept"),)) == 1.0
    assert apart((("111",), ("kept",)), (("111",), ("kept",))) == 0.0
