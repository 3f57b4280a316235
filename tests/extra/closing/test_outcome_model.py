"""What is learned of combinations, from which the next ones are chosen."""

from __future__ import annotations

from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.extra.closing.interactions import UNDISTURBED, Combination, Interaction, Intervention
from pytest_hricdv.extra.closing.outcome_model import PRIOR_CHANCE, OutcomeModel

PUSH, PULL, LIGHT = Intervention(1, "push"), Intervention(2, "pull"), Intervention(1, "light")
GIVEN = ("outcome", "given")


def seen(planned: Bin, combination: Combination, reading: str, outcome: str) -> Interaction:
    """An interaction with a reading, of another cross product, and an outcome."""
    return Interaction(planned, combination, (("outcome", outcome), ("reading", reading)))


def usually_kept() -> OutcomeModel:
    """Without disturbances, whoever stands as "00" or "01" is given nothing."""
    model = OutcomeModel(2)
    model.learn([seen((legs, pose), UNDISTURBED, pose, "kept") for legs in "12" for pose in ("00", "01")] * 4)
    return model


def test_what_led_to_an_outcome_is_best_where_the_other_coordinates_are_similar() -> None:
    model = usually_kept()
    model.learn([seen(("1", "01"), (PUSH,), "11", "given")])
    candidate = model.best(("2", "01"), GIVEN, commands=3)
    assert candidate is not None
    assert candidate.combination == (PUSH,)
    assert candidate.chance > PRIOR_CHANCE


def test_what_fails_again_and_again_is_expected_no_more() -> None:
    model = usually_kept()
    model.learn([seen(("1", "01"), (PUSH,), "11", "given")])
    model.learn([seen(("2", "01"), (PUSH,), "01", "kept")] * 10)
    assert model.chance(("2", "01"), (PUSH,), GIVEN) < 0.1


def test_what_comes_without_a_disturbance_is_not_ascribed_to_one() -> None:
    model = OutcomeModel(2)
    model.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 5)
    model.learn([seen(("1", "11"), (LIGHT,), "11", "given")])
    assert model.best(("1", "01"), GIVEN, commands=3) is None


def test_a_combination_is_made_to_fit_into_a_shorter_interaction() -> None:
    model = usually_kept()
    model.learn([seen(("1", "00"), (PULL,), "11", "given")])
    candidate = model.best(("2", "00"), GIVEN, commands=1)
    assert candidate is not None
    assert candidate.combination == (PULL._replace(place=1),)
    assert candidate.chance > PRIOR_CHANCE


def test_a_nominal_effect_that_was_never_seen_is_taken_from_similar_coordinates_and_only_from_these() -> None:
    model = usually_kept()
    assert model.nominal(("3", "00")) == model.nominal(("1", "00"))
    assert model.nominal(("3", "11")) is None
