"""Combinations that are put together from interventions whose effects are known."""

from __future__ import annotations

from pytest_hricdv.extra.closing.combination_synthesis import CombinationSynthesis
from pytest_hricdv.extra.closing.interactions import UNDISTURBED
from pytest_hricdv.extra.closing.outcome_model import OutcomeModel
from pytest_hricdv.generate.rng import make_rng
from tests.extra.closing.test_outcome_model import GIVEN, LIGHT, PULL, PUSH, seen, usually_kept


def each_sets_one_bit() -> OutcomeModel:
    """Pushing and pulling each set one of two bits; light sets none."""
    model = usually_kept()
    model.learn([seen(("1", "11"), UNDISTURBED, "11", "given")])
    model.learn([seen(("1", "00"), (PUSH,), "10", "kept"), seen(("1", "00"), (PULL,), "01", "kept")] * 2)
    model.learn([seen(("1", "00"), (LIGHT,), "00", "kept")] * 5)
    return model


def test_interventions_for_each_missing_bit_are_put_together() -> None:
    candidate = CombinationSynthesis(each_sets_one_bit()).synthesize(("1", "00"), GIVEN, 3, make_rng("together"))
    assert candidate is not None
    assert candidate.combination == (PUSH, PULL)


def test_what_is_put_together_and_fails_is_expected_no_more() -> None:
    model = each_sets_one_bit()
    first = CombinationSynthesis(model).synthesize(("1", "00"), GIVEN, 3, make_rng("together"))
    model.learn([seen(("1", "00"), (PUSH, PULL), "00", "kept")] * 8)
    last = CombinationSynthesis(model).synthesize(("1", "00"), GIVEN, 3, make_rng("together"))
    assert first is not None
    assert last is not None
    assert first.chance > 2 * last.chance


def test_where_no_intervention_has_brought_about_what_is_missing_there_is_no_combination() -> None:
    assert CombinationSynthesis(usually_kept()).synthesize(("1", "00"), GIVEN, 3, make_rng("unknown")) is None


def test_disturbances_that_change_what_is_missing_promise_most_and_those_that_do_not_less_than_unknown_ones() -> None:
    model = usually_kept()
    model.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    model.learn([seen(("1", "11"), (PUSH,), "01", "kept"), seen(("1", "11"), (LIGHT,), "10", "kept")])
    promise = CombinationSynthesis(model).promise_changes(("push", "pull", "light"), ("1", "01"), GIVEN, commands=3)
    assert promise["push"] > promise["pull"] > promise["light"]


def test_what_one_intervention_changes_another_one_may_mask() -> None:
    model = usually_kept()
    model.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    model.learn([seen(("1", "11"), (PULL,), "10", "kept"), seen(("2", "01"), (PUSH,), "01", "kept")] * 3)
    assert CombinationSynthesis(model).mask(("1", "11"), 3, make_rng("hidden")) is None
    model.learn([seen(("2", "00"), (PUSH,), "01", "kept")] * 3)
    assert CombinationSynthesis(model).mask(("1", "11"), 3, make_rng("hidden")) == (PUSH, PULL)
    assert CombinationSynthesis(model).mask(("3", "11"), 3, make_rng("hidden")) == (PUSH, PULL)
