"""The four methods on the models of the table assembly: the suites are similar to the published ones."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from pytest_hricdv.generate.concrete import concretize, expand
from pytest_hricdv.generate.methods import METHODS
from pytest_hricdv.generate.suite import Suite
from tests.generate.table import COMMANDS, CONCRETIZATION, CONTEXT

SIZES = {"by-hand": 138, "bdi-random": 100, "rl": 134, "pseudorandom": 100}


@cache
def _suite(method: str, seed: int) -> Suite:
    return METHODS[method].generate(replace(CONTEXT, seed=seed))


@pytest.mark.parametrize("method", list(SIZES))
def test_suites_have_the_published_sizes_and_every_test_can_be_concretized(method: str) -> None:
    suite = _suite(method, 0)
    assert len(suite.tests) == SIZES[method]
    assert all(note.startswith("uncovered plans: human: plan") for note in suite.generation.notes)
    for test in expand(suite.tests, 2):
        concrete = concretize(test, CONCRETIZATION)
        assert [action.command for action in concrete.actions] == list(test.lines)
        assert set(test.lines) <= set(COMMANDS)


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
