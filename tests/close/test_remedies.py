"""What doses mend."""

from __future__ import annotations

from pytest_hricdv.close.interactions import UNDISTURBED
from pytest_hricdv.close.recipes import Recipes
from pytest_hricdv.close.remedies import Lack, Remedies, has, lacking
from tests.close.test_recipes import LIGHT, PULL, PUSH, seen, usually_kept

KEPT = (("outcome", "kept"), ("reading", "00"))
GIVEN = (("outcome", "given"), ("reading", "10"))


def test_letters_are_lacking_where_patterns_differ_and_texts_only_where_none_does() -> None:
    assert lacking(KEPT, GIVEN) == (Lack(3, 0, "1"),)
    assert lacking((("outcome", "kept"), ("reading", "10")), GIVEN) == (Lack(1, -1, "given", "kept"),)
    assert has(GIVEN, Lack(3, 0, "1"))
    assert not has(KEPT, Lack(3, 0, "1"))


def test_a_dose_mends_a_letter_whatever_the_others_are() -> None:
    recipes = usually_kept()
    recipes.learn([seen(("1", "01"), (PUSH,), "11", "given"), seen(("1", "00"), (PULL,), "00", "kept")])
    assert set(Remedies(recipes).against(Lack(3, 0, "1"))) == {PUSH}


def test_what_comes_after_a_disturbed_interaction_counts_less() -> None:
    recipes = usually_kept()
    recipes.learn([seen(("1", "00"), (PUSH,), "10", "kept")])
    recipes.learn([seen(("1", "00"), (LIGHT,), "10", "kept")._replace(is_clean=False)])
    chances = Remedies(recipes).against(Lack(3, 0, "1"))
    assert chances[PUSH] > chances[LIGHT] > 0.0


def test_effects_of_other_cross_products_are_not_compared() -> None:
    recipes = usually_kept()
    recipes.learn([seen(("1", "00"), (PUSH,), "10", "kept")._replace(effect=(("outcome", "given"),))])
    assert not Remedies(recipes).against(Lack(3, 0, "1"))


def test_nothing_is_known_where_nothing_was_run_undisturbed() -> None:
    recipes = Recipes(2)
    recipes.learn([seen(("1", "00"), (PUSH,), "10", "kept"), seen(("1", "00"), UNDISTURBED, "0", "lost")][:1])
    assert not Remedies(recipes).against(Lack(3, 0, "1"))


def test_a_text_as_a_whole_is_mended_by_what_has_mended_the_same_text() -> None:
    recipes = usually_kept()
    recipes.learn([seen(("1", "away"), UNDISTURBED, "none", "silent")])
    recipes.learn([seen(("1", "01"), (PUSH,), "11", "given"), seen(("1", "away"), (PULL,), "11", "given")])
    assert set(Remedies(recipes).against(Lack(1, -1, "given", "kept"))) == {PUSH}
    assert set(Remedies(recipes).against(Lack(1, -1, "given", "silent"))) == {PULL}
