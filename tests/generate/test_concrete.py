"""Concretization: samplers, random streams, variants."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import (
    ConcreteTest,
    Concretization,
    abstract_from,
    check_values,
    concretize,
    expand,
    variant,
)
from pytest_hricdv.generate.sampler import Constant, Sometimes, Uniform
from tests.generate.table import COMMANDS, CONCRETIZATION

finite = st.floats(-1e9, 1e9)
TEST = AbstractTest(id="t", suite="s", target="a", beliefs=(), lines=COMMANDS, seed=123456789)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Uniform(2.0, 1.0, "m"), r"range \[2, 1\] m is reversed"),
        (lambda: Uniform(1.0, 1.0, open_high=True), r"range \[1, 1\) is empty"),
        (lambda: Uniform(0.0, math.inf), "finite"),
        (lambda: Constant(math.nan), "finite"),
        (lambda: Sometimes(1.2, Constant(1.0)), "a chance of 1.2: expected a probability from 0 to 1"),
        (lambda: Sometimes(-0.1, Constant(1.0)), "from 0 to 1"),
        (lambda: Concretization({"set_param gaze=1": {}}), "expected the spelling 'set_param gaze = 1'"),
        (lambda: Concretization({"bored": {"x": 3}}), "'bored': parameter 'x' is 3; expected a Uniform"),  # type: ignore[dict-item]
        (lambda: Concretization({}, {"x": 3}), "of a run: parameter 'x' is 3"),  # type: ignore[dict-item]
        (lambda: concretize(replace(TEST, lines=("tell legs",)), CONCRETIZATION), "'tell legs'; nearest: tell leg"),
        (lambda: expand([TEST], 0), "0 concretizations"),
        (lambda: variant(TEST, -1), "at least 0"),
        (lambda: ConcreteTest.from_json("{}"), "not a concrete test"),
        (lambda: ConcreteTest.from_json("["), "not a concrete test"),
    ],
)
def test_invalid_arguments_are_errors(make: Callable[[], object], message: str) -> None:
    with pytest.raises(GenerateError, match=message):
        make()


def test_parameters_lie_in_their_ranges() -> None:
    for seed in range(50):
        actions = {a.command: a.parameters for a in concretize(replace(TEST, seed=seed), CONCRETIZATION).actions}
        assert 0.1 <= actions["set_param gaze = 1"]["offset_m"] <= 0.2
        assert 15.0 <= actions["set_param gaze = 1"]["angle_deg"] < 40.0
        assert actions["set_param pressure = 0"]["pull_n"] == 0.0 or actions["set_param pressure = 0"]["pull_n"] >= 1.0
        assert actions["bored"] == {}


@given(st.integers(0, 2**63 - 1), st.integers(0, 5))
def test_concretization_is_a_function_of_the_test_and_k(seed: int, k: int) -> None:
    test = replace(TEST, seed=seed)
    assert concretize(test, CONCRETIZATION, k) == concretize(test, CONCRETIZATION, k)
    assert concretize(test, CONCRETIZATION, k) == concretize(variant(test, k), CONCRETIZATION)


CHOSEN = {1: {"hand_x_m": 0.25}, 3: {"offset_m": 0.125}, 0: {"sensing_timeout_s": 15.5}}


@given(st.integers(0, 3))
def test_chosen_values_are_taken_and_all_others_are_drawn_as_without_them(k: int) -> None:
    drawn, chosen = concretize(TEST, CONCRETIZATION, k), concretize(replace(TEST, values=CHOSEN), CONCRETIZATION, k)
    assert chosen.run == {"sensing_timeout_s": 15.5}
    for number, (before, after) in enumerate(zip(drawn.actions, chosen.actions, strict=True), 1):
        assert after.parameters == {**before.parameters, **CHOSEN.get(number, {})}
        assert list(after.parameters) == list(before.parameters)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (
            {1: {"hand_y_m": 0.1}},
            r"test t, command 1 \(tell leg\): no parameter 'hand_y_m'; nearest: hand_x_m; declared: ",
        ),
        ({10: {"x_m": 0.1}}, r"command 10 \(bored\): no parameter 'x_m'; declared: none"),
        ({0: {"x_s": 1.0}}, "test t, the run: no parameter 'x_s'"),
        (
            {1: {"hand_x_m": 0.5}},
            r"command 1 \(tell leg\): hand_x_m 0.5 is out of its range; expected range \[-0.1, 0.4\] m",
        ),
        ({1: {"voice_s": 3.5}}, "voice_s 3.5 is out of its range; expected 3 s"),
        ({3: {"angle_deg": 40.0}}, r"expected range \[15, 40\) deg"),
        ({6: {"pull_n": 0.5}}, r"pull_n 0.5 is out of its range; expected 0 or range \[1, 3\] N"),
    ],
)
def test_a_value_that_cannot_be_chosen_is_a_located_error(
    values: Mapping[int, Mapping[str, float]], message: str
) -> None:
    test = replace(TEST, values=values)
    for use in (concretize, check_values):
        with pytest.raises(GenerateError, match=message):
            use(test, CONCRETIZATION)


@given(st.integers(0, 2**63 - 1))
def test_a_concrete_test_as_an_abstract_one_concretizes_to_itself(seed: int) -> None:
    drawn = concretize(replace(TEST, seed=seed), CONCRETIZATION)
    stored = abstract_from(drawn, "found online", name="a title")
    assert concretize(stored, CONCRETIZATION) == replace(drawn, id=stored.id)
    assert (stored.suite, stored.seed, stored.lines, stored.name) == ("s", seed, COMMANDS, "a title")
    assert stored.id.startswith("s-found-online-")
    other = replace(drawn, run={"sensing_timeout_s": 11.0})
    assert abstract_from(other, "found online").id != stored.id
    assert concretize(abstract_from(drawn, "the same", keeps_id=True), CONCRETIZATION) == drawn


@given(st.integers(0, 2**63 - 1))
def test_json_is_exact(seed: int) -> None:
    test = concretize(replace(TEST, seed=seed), CONCRETIZATION)
    assert ConcreteTest.from_json(test.to_json()) == test
