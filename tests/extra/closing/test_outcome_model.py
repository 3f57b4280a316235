"""What is learned of combinations, from which the next ones are chosen."""

from __future__ import annotations

from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.extra.closing.interactions import UNDISTURBED, Combination, Interaction, Intervention, Outcome
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


def test_where_combinations_from_elsewhere_have_failed_others_are_trusted_less() -> None:
    def after(wanted: tuple[Outcome, ...]) -> OutcomeModel:
        model = usually_kept()
        model.learn([seen(("1", "01"), (intervention,), "11", "given") for intervention in (PUSH, PULL, LIGHT)])
        model.learn(
            [seen(("1", "00"), (intervention,), "00", "kept")._replace(wanted=wanted) for intervention in (PUSH, PULL)]
        )
        return model

    failed, not_aimed = after((GIVEN,)), after(())
    for planned, factor in ((("2", "00"), 0.5), (("2", "01"), 1.0)):  # in the second, the same usually comes
        candidate, other = (each.best(planned, GIVEN, commands=3) for each in (failed, not_aimed))
        assert candidate is not None
        assert other is not None
        assert candidate.chance <= factor * other.chance
        last = (candidate.chance, other.chance)
    assert last[0] == last[1] > PRIOR_CHANCE


def test_values_of_a_coordinate_that_makes_no_difference_are_learned_to_be_similar() -> None:
    model, outcome = OutcomeModel(2), {"00": "kept", "01": "silent"}
    model.learn([seen((legs, pose), UNDISTURBED, pose, outcome[pose]) for legs in "123" for pose in ("00", "01")] * 5)
    model.learn([seen(("1", "00"), (PUSH,), "11", "given")])
    other_legs = model.chance(("2", "00"), (PUSH,), GIVEN)
    other_pose = model.chance(("1", "01"), (PUSH,), GIVEN)
    assert other_legs > 0.6 > 0.3 > other_pose


def test_what_comes_without_a_disturbance_is_not_ascribed_to_one() -> None:
    model = OutcomeModel(2)
    model.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 5)
    model.learn([seen(("1", "11"), (LIGHT,), "11", "given")])
    assert model.best(("1", "01"), GIVEN, commands=3) is None


def test_a_part_of_a_combination_may_do() -> None:
    model = usually_kept()
    model.learn([seen(("1", "00"), (PUSH, PULL), "11", "given")])
    model.learn([seen(("1", "01"), (PUSH, PULL), "01", "kept")] * 5)
    candidate = model.best(("1", "01"), GIVEN, commands=3)
    assert candidate is not None
    assert len(candidate.combination) == 1


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


def test_what_a_longer_interaction_has_shown_counts_until_the_shorter_one_was_tried() -> None:
    model = usually_kept()
    model.learn([seen(("1", "00"), (PULL,), "11", "given")] * 4)
    before = model.best(("2", "00"), GIVEN, commands=1)
    model.learn([seen(("3", "00"), (PULL._replace(place=1),), "00", "kept")] * 2)
    after = model.best(("2", "00"), GIVEN, commands=1)
    assert before is not None
    assert after is not None
    assert after.chance < 0.4 * before.chance


def test_what_comes_of_nothing_after_a_disturbed_interaction_says_nothing_of_undisturbed_ones() -> None:
    """A disturbance may last: a part that is late is missing in the next interaction."""
    model = usually_kept()
    before = model.chance(("1", "00"), UNDISTURBED, ("outcome", "kept"))
    model.learn([seen(("1", "00"), UNDISTURBED, "none", "silent")._replace(is_isolated=False)] * 9)
    assert model.chance(("1", "00"), UNDISTURBED, ("outcome", "kept")) == before
    assert model.nominal(("1", "00")) == (("outcome", "kept"), ("reading", "00"))
