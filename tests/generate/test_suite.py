"""Suites as data, and their diagnosis."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.methods import ReinforcementLearning
from pytest_hricdv.generate.suite import Generation, Suite, entropy_bits
from tests.generate.strategies import abstract_tests
from tests.generate.table import CONTEXT

generations = st.builds(
    Generation,
    bdi_runs=st.integers(0, 9999),
    iterations=st.integers(0, 1000),
    converged_at=st.none() | st.integers(1, 1000),
    q_delta=st.lists(st.floats(0.0, 20.0), max_size=4).map(tuple),
    declared_plans=st.just({"human": ("plan1", "plan2")}),
    notes=st.lists(st.text(), max_size=2).map(tuple),
)


@given(st.lists(abstract_tests, max_size=4, unique_by=lambda test: test.id), generations, st.integers(0, 2**40))
def test_json_gives_the_suite_back(tests: list, generation: Generation, seed: int) -> None:  # type: ignore[type-arg]
    suite = Suite.of_tests("any", seed, tests, generation)
    assert Suite.from_json(suite.to_json()) == suite
    assert Suite.from_json(suite.to_json()).to_json() == suite.to_json()
    assert suite.generation.distinct_texts == len({test.lines for test in tests})


@given(abstract_tests)
def test_two_tests_with_one_id_are_an_error(test: object) -> None:
    with pytest.raises(GenerateError, match="two tests have the id"):
        Suite("s", 0, (test, test))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[]", "not a suite"),
        ("{", "not a suite"),
        ('{"schema": "hricdv-suite/0"}', "schema 'hricdv-suite/0'; expected 'hricdv-suite/3'"),
        ('{"schema": "hricdv-suite/3", "tests": [{}]}', "not a suite"),
    ],
)
def test_other_text_is_no_suite(text: str, message: str) -> None:
    with pytest.raises(GenerateError, match=message):
        Suite.from_json(text)


@given(st.dictionaries(st.text(max_size=3), st.integers(1, 99), min_size=1, max_size=30))
def test_entropy_is_largest_for_equal_counts(uses: dict[str, int]) -> None:
    most = math.log2(len(uses))
    assert -1e-9 <= entropy_bits(Counter(uses)) <= most + 1e-9
    assert entropy_bits(Counter(dict.fromkeys(uses, 7))) == pytest.approx(most)


@pytest.mark.parametrize("seed", [0, 1])
def test_the_reward_uncovered_covers_all_plans_of_the_table_and_the_published_one_does_not(
    seed: int,
) -> None:
    context = replace(CONTEXT, seed=seed)
    published = ReinforcementLearning().generate(context)
    learning = replace(context.learning, reward="uncovered", model_runs=750)
    uncovered = ReinforcementLearning().generate(replace(context, learning=learning))
    assert published.plans_not_covered()["human"]
    assert uncovered.plans_not_covered() == {}
    assert uncovered.generation.bdi_runs <= published.generation.bdi_runs
    assert uncovered.generation.distinct_texts > published.generation.distinct_texts
