"""The four methods on the models of the table assembly: the suites are similar to the published ones."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache

import pytest

from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import concretize, expand
from pytest_hricdv.generate.methods import METHODS
from pytest_hricdv.generate.suite import Suite
from tests.generate.table import COMMANDS, CONCRETIZATION, CONTEXT, SPACE

SIZES = {"by-hand": 138, "bdi-random": 100, "rl": 134, "pseudorandom": 100}
READY = ("set_param gaze = 1", "set_param location = 1", "set_param pressure = 1")


@cache
def _suite(method: str, seed: int) -> Suite:
    return METHODS[method].generate(replace(CONTEXT, seed=seed))


def _offers(test: AbstractTest) -> list[tuple[str, ...]]:
    """The human's actions between the signal for a leg and the answer, sorted, per leg."""
    asked = " ; ".join(test.lines).split("receivesignal ; ")[1:]
    return [tuple(sorted(re.findall(r"set_param \w+ = \d", leg))) for leg in asked]


def _with_a_ready_leg(suite: Suite) -> int:
    return sum(READY in _offers(test) for test in suite.tests)


@pytest.mark.parametrize("method", list(SIZES))
def test_suites_have_the_published_sizes_and_every_test_can_be_concretized(method: str) -> None:
    suite = _suite(method, 0)
    assert len(suite.tests) == SIZES[method]
    assert all(note.startswith("uncovered plans: human: plan") for note in suite.generation.notes)
    for test in expand(suite.tests, 2):
        concrete = concretize(test, CONCRETIZATION)
        assert [action.command for action in concrete.actions] == list(test.lines)
        assert set(test.lines) <= set(COMMANDS)


@pytest.mark.parametrize("method", list(SIZES))
def test_json_gives_each_suite_back(method: str) -> None:
    assert Suite.from_json(_suite(method, 0).to_json()) == _suite(method, 0)


@pytest.mark.parametrize("method", ["by-hand", "rl", "bdi-random"])
def test_some_tests_release_a_leg_some_do_not_and_some_get_bored(method: str) -> None:
    suite = _suite(method, 0)
    ready = _with_a_ready_leg(suite)
    assert len(suite.tests) // 10 <= ready < len(suite.tests)
    assert sum("bored" in test.lines for test in suite.tests) >= len(suite.tests) // 10


def test_most_tests_by_hand_release_a_leg() -> None:
    assert _with_a_ready_leg(_suite("by-hand", 0)) >= 90


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_rl_converges_and_covers_the_robot_model(seed: int) -> None:
    suite = _suite("rl", seed)
    assert len({test.beliefs for test in suite.tests}) == 134
    assert suite.generation.converged_at is not None
    covered, declared = suite.plans_covered(), suite.generation.declared_plans
    assert len(declared["robot_code"]) == 12
    assert len(declared["human"]) == 48
    assert set(covered["robot_code"]) == set(declared["robot_code"])
    assert len(covered["human"]) >= 40
    assert ("human" in suite.plans_not_covered()) == bool(suite.generation.notes)


def test_bdi_pseudorandom_covers_both_models() -> None:
    assert _suite("bdi-random", 0).plans_not_covered() == {}


def test_other_seeds_give_other_tests() -> None:
    subsets = [{test.beliefs for test in _suite("rl", seed).tests} for seed in (0, 1, 2)]
    assert len(subsets[0] & subsets[1]) < 60
    assert len(subsets[1] & subsets[2]) < 60


def test_every_subset_begins_with_one_start_belief() -> None:
    for test in (*_suite("rl", 0).tests, *_suite("bdi-random", 0).tests):
        assert test.beliefs[0] in SPACE.start
        assert not set(test.beliefs[1:]) & set(SPACE.start)
