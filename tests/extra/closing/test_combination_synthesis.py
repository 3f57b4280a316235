"""Combinations that are put together from interventions whose effects are known."""

from __future__ import annotations

from collections import Counter

from pytest_hricdv.extra.closing.combination_synthesis import MAX_INTERVENTIONS, CombinationSynthesis
from pytest_hricdv.extra.closing.interactions import UNDISTURBED, Intervention
from pytest_hricdv.extra.closing.outcome_model import OutcomeModel, fitted
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
    candidate = CombinationSynthesis(each_sets_one_bit()).drawn(("1", "00"), GIVEN, 3, make_rng("together"))
    assert candidate is not None
    assert candidate.combination == (PUSH, PULL)


def test_what_is_put_together_and_fails_is_expected_no_more() -> None:
    model = each_sets_one_bit()
    first = CombinationSynthesis(model).drawn(("1", "00"), GIVEN, 3, make_rng("together"))
    model.learn([seen(("1", "00"), (PUSH, PULL), "00", "kept")] * 8)
    last = CombinationSynthesis(model).drawn(("1", "00"), GIVEN, 3, make_rng("together"))
    assert first is not None
    assert last is not None
    assert first.chance > 2 * last.chance


def test_what_is_missing_after_a_deviation_is_brought_about_too() -> None:
    model = each_sets_one_bit()
    model.learn([seen(("1", "away"), UNDISTURBED, "none", "silent")] * 2)
    model.learn([seen(("1", "away"), (LIGHT,), "01", "kept")] * 2)
    candidate = CombinationSynthesis(model).drawn(("1", "away"), GIVEN, 3, make_rng("away"))
    assert candidate is not None
    assert candidate.combination == (LIGHT, PUSH)


def test_a_combination_in_vain_is_expected_less_and_an_incomplete_one_does_not_count() -> None:
    model = each_sets_one_bit()
    model.learn([seen(("1", "away"), UNDISTURBED, "none", "silent")] * 2)
    model.learn([seen(("1", "away"), (LIGHT,), "01", "kept")] * 2)
    before = CombinationSynthesis(model).drawn(("1", "away"), GIVEN, 3, make_rng("away"))
    other = seen(("1", "away"), (LIGHT, PULL), "01", "kept")._replace(wanted=(GIVEN,))
    model.learn([other] * 3)
    same = CombinationSynthesis(model).drawn(("1", "away"), GIVEN, 3, make_rng("away"))
    model.learn([seen(("1", "away"), (LIGHT, PUSH), "11", "kept")._replace(wanted=(GIVEN,))] * 3)
    after = CombinationSynthesis(model).drawn(("1", "away"), GIVEN, 3, make_rng("away"))
    assert before is not None
    assert same is not None
    assert after is not None
    assert same.chance > 0.9 * before.chance
    assert after.chance < 0.6 * before.chance


def test_a_deviation_of_many_interventions_loses_some_of_these() -> None:
    model = each_sets_one_bit()
    many = tuple(Intervention(1, f"other{number}") for number in range(MAX_INTERVENTIONS))
    model.learn([seen(("1", "away"), UNDISTURBED, "none", "silent")] * 2)
    model.learn([seen(("1", "away"), many, "01", "kept")] * 4)
    candidate = CombinationSynthesis(model).drawn(("1", "away"), GIVEN, 3, make_rng("many"))
    assert candidate is not None
    assert PUSH in candidate.combination
    assert set(candidate.combination) < {PUSH, *many}
    assert len(candidate.combination) == MAX_INTERVENTIONS


def test_where_no_intervention_has_brought_about_what_is_missing_there_is_no_combination() -> None:
    assert CombinationSynthesis(usually_kept()).drawn(("1", "00"), GIVEN, 3, make_rng("unknown")) is None


def test_disturbances_that_change_what_is_missing_promise_most_and_those_that_do_not_less_than_unknown_ones() -> None:
    model = usually_kept()
    model.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    model.learn([seen(("1", "11"), (PUSH,), "01", "kept"), seen(("1", "11"), (LIGHT,), "10", "kept")])
    promise = CombinationSynthesis(model).expected_changes(("push", "pull", "light"), ("1", "01"), GIVEN, commands=3)
    assert promise["push"] > promise["pull"] > promise["light"]


def test_new_interventions_are_for_the_bits_that_no_known_one_sets() -> None:
    model = usually_kept()
    model.learn([seen(("1", "00"), (PUSH,), "10", "kept")] * 9)
    model.learn([seen(("2", "00"), (PULL,), "00", "kept")])
    model.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    promise = CombinationSynthesis(model).expected_changes(("push", "pull", "light"), ("1", "00"), GIVEN, commands=3)
    assert max(promise, key=lambda name: promise[name]) == "light"


def test_what_one_intervention_changes_another_one_may_mask() -> None:
    model = usually_kept()
    model.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    model.learn([seen(("1", "11"), (PULL,), "10", "kept"), seen(("2", "01"), (PUSH,), "01", "kept")] * 3)
    assert CombinationSynthesis(model).masked(("1", "11"), 3, make_rng("hidden")) is None
    model.learn([seen(("2", "00"), (PUSH,), "01", "kept")] * 3)
    assert CombinationSynthesis(model).masked(("1", "11"), 3, make_rng("hidden")) == (PUSH, PULL)
    assert CombinationSynthesis(model).masked(("3", "11"), 3, make_rng("hidden")) == (PUSH, PULL)


def test_what_is_still_missing_when_something_was_masked_is_brought_about_too() -> None:
    model = each_sets_one_bit()
    model.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    model.learn([seen(("1", "11"), (LIGHT,), "01", "kept")] * 3)
    assert CombinationSynthesis(model).masked(("1", "11"), 3, make_rng("hidden")) == fitted((LIGHT, PUSH), 3)
    model.learn([seen(("1", "11"), fitted((LIGHT, PUSH), 3), "10", "kept")])
    assert CombinationSynthesis(model).masked(("1", "11"), 3, make_rng("hidden")) == fitted((LIGHT, PUSH, PULL), 3)
    model.learn([seen(("1", "11"), fitted((LIGHT, PUSH, PULL), 3), "11", "given")])
    assert CombinationSynthesis(model).masked(("1", "11"), 3, make_rng("hidden")) == fitted((LIGHT, PUSH, PULL), 3)


def test_what_leads_to_an_outcome_is_tried_beside_what_changes_it_where_it_is_nominal() -> None:
    model = each_sets_one_bit()
    model.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    model.learn([seen(("1", "11"), (LIGHT,), "01", "kept")] * 3)
    assert CombinationSynthesis(model).beside(("1", "00"), GIVEN, 3, make_rng("beside")) is None
    model.learn([seen(("1", "00"), (PUSH, PULL), "11", "given")] * 3)
    assert CombinationSynthesis(model).beside(("1", "00"), GIVEN, 3, make_rng("beside")) == fitted(
        (PUSH, PULL, LIGHT), 3
    )


def test_what_was_missing_when_a_change_was_tried_beside_it_is_brought_about_too() -> None:
    model = each_sets_one_bit()
    shout = Intervention(1, "shout")
    model.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    model.learn([seen(("1", "11"), (LIGHT,), "01", "kept"), seen(("1", "00"), (shout,), "10", "kept")] * 3)
    model.learn([seen(("1", "00"), (PUSH, PULL), "11", "given")] * 3)
    model.learn([seen(("1", "00"), fitted((PUSH, PULL, LIGHT), 3), "01", "kept")])
    found = CombinationSynthesis(model).beside(("1", "00"), GIVEN, 3, make_rng("beside"))
    assert found == fitted((PUSH, PULL, LIGHT, shout), 3)


def test_a_change_to_quite_another_effect_cannot_be_tried_beside_it() -> None:
    model = each_sets_one_bit()
    model.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    model.learn([seen(("1", "11"), (LIGHT,), "none", "silent"), seen(("1", "00"), (PUSH, PULL), "11", "given")] * 3)
    assert CombinationSynthesis(model).beside(("1", "00"), GIVEN, 3, make_rng("beside")) is None


def pushed_and_pulled(tries: int, came: str) -> int:
    """How often of 100 times pushing is to mask pulling, after so many tries in which this came; it may mask light."""
    model = usually_kept()
    model.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    for intervention in (PULL, LIGHT):
        model.learn([seen(("1", "11"), (intervention,), "10", "kept")] * 3)
    model.learn([seen(("2", "00"), (PUSH,), "01", "kept")] * 30)
    model.learn([seen(("1", "11"), (PUSH, PULL), came, "given")] * tries)
    rng = make_rng("rare")
    return sum(CombinationSynthesis(model).masked(("1", "11"), 3, rng) == (PUSH, PULL) for _ in range(100))


def test_what_was_rarely_combined_is_rather_masked() -> None:
    assert pushed_and_pulled(9, "11") < 0.5 * pushed_and_pulled(0, "11")


def test_what_was_masked_and_nothing_came_of_it_is_masked_less_also_in_other_ways() -> None:
    def pulled(tries: int) -> int:
        model = usually_kept()
        model.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
        model.learn([seen(("1", "11"), (intervention,), "10", "kept") for intervention in (PULL, LIGHT)] * 3)
        model.learn([seen(("2", "00"), (PUSH,), "01", "kept")] * 30)
        model.learn(
            [seen(("1", "11"), (Intervention(1, f"other{number}"), PULL), "11", "given") for number in range(tries)]
        )
        rng = make_rng("nothing")
        return sum(PULL in (CombinationSynthesis(model).masked(("1", "11"), 3, rng) or ()) for _ in range(100))

    assert pulled(9) < 0.5 * pulled(0)


def test_a_disturbance_of_which_many_interventions_are_known_is_masked_no_more_often_than_another() -> None:
    """Nine interventions of light change what one of pulling does; pushing masks both."""
    model = usually_kept()
    model.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    lights = [LIGHT._replace(values=(("lux", 0.1 * number),)) for number in range(9)]
    model.learn([seen(("1", "11"), (intervention,), "10", "kept") for intervention in (*[PULL] * 9, *lights)])
    model.learn([seen(("2", "00"), (PUSH,), "01", "kept")] * 30)
    rng = make_rng("alike")
    masked = [CombinationSynthesis(model).masked(("1", "11"), 3, rng) or () for _ in range(100)]
    pairs = Counter(frozenset(intervention.name for intervention in combination) for combination in masked)
    assert pairs[frozenset({"push", "light"})] < 2 * pairs[frozenset({"push", "pull"})]


def test_tries_in_which_something_else_went_wrong_do_not_count() -> None:
    assert pushed_and_pulled(9, "none") > 0.7 * pushed_and_pulled(0, "none")


def test_what_changes_a_bit_where_something_else_is_planned_is_masked_too() -> None:
    model = usually_kept()
    model.learn([seen(("1", "11"), UNDISTURBED, "11", "given")] * 2)
    model.learn([seen(("2", "01"), (PULL,), "00", "kept"), seen(("2", "00"), (PUSH,), "01", "kept")] * 3)
    assert CombinationSynthesis(model).masked(("1", "11"), 3, make_rng("hidden")) == (PUSH, PULL)


def test_a_combination_with_an_effect_is_tried_without_one_of_its_interventions() -> None:
    model = usually_kept()
    model.learn([seen(("1", "00"), (LIGHT, PUSH, PULL), "11", "given")] * 2)
    model.learn([seen(("1", "00"), (LIGHT, PUSH), "10", "kept")])
    synthesis = CombinationSynthesis(model)
    found = {synthesis.reduced(("2", "00"), 3, make_rng(str(number))) for number in range(20)}
    assert found == {(PUSH, PULL), (LIGHT, PULL), (LIGHT,), (PUSH,)}
    assert CombinationSynthesis(usually_kept()).reduced(("2", "00"), 3, make_rng("none")) is None


def test_a_combination_that_has_to_be_moved_to_fit_counts_until_it_was_tried() -> None:
    model = usually_kept()
    model.learn([seen(("1", "00"), (PULL,), "11", "given")] * 4)
    before = CombinationSynthesis(model).drawn(("1", "00"), GIVEN, 1, make_rng("moved"))
    model.learn([seen(("2", "00"), fitted((PULL,), 1), "00", "kept")])
    after = CombinationSynthesis(model).drawn(("1", "00"), GIVEN, 1, make_rng("moved"))
    assert before is not None
    assert before.combination == fitted((PULL,), 1)
    assert after is None or after.chance < 0.5 * before.chance
