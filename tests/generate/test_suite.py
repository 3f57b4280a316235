"""Suites as data, and the cache's key."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.generate.error import GenerateError
from pytest_hricdv.generate.qlearning import QLearning
from pytest_hricdv.generate.suite import Generation, Suite, fingerprint
from pytest_hricdv.generate.text import parse_tests
from tests.generate.strategies import abstract_tests
from tests.generate.table import SPACE

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


def test_covered_plans_are_those_of_all_tests() -> None:
    generation = Generation(declared_plans={"human": ("p1", "p2"), "robot": ("r1",)})
    text = "# id: {0}\n# suite: s\n# aim: a\n# seed: 1\n# plans human: p{0}\n"
    tests = parse_tests("\n".join(map(text.format, (2, 1))), file="f", suite="s")
    assert Suite.of_tests("s", 0, tests, generation).covered_plans() == {"human": ("p1", "p2"), "robot": ()}
    assert Suite.of_tests("s", 0, tests, generation).uncovered_plans() == {"robot": ("r1",)}


@given(abstract_tests)
def test_two_tests_with_one_id_are_an_error(test: object) -> None:
    with pytest.raises(GenerateError, match="two tests have the id"):
        Suite("s", 0, (test, test))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[]", "not a suite"),
        ("{", "not a suite"),
        ('{"schema": "hricdv-suite/0"}', "schema 'hricdv-suite/0'; expected 'hricdv-suite/2'"),
        ('{"schema": "hricdv-suite/2", "tests": [{}]}', "not a suite"),
    ],
)
def test_other_text_is_no_suite(text: str, message: str) -> None:
    with pytest.raises(GenerateError, match=message):
        Suite.from_json(text)


def test_the_fingerprint_changes_with_whatever_a_suite_depends_on(tmp_path: Path) -> None:
    here, there = tmp_path / "a.asl", tmp_path / "elsewhere" / "a.asl"
    there.parent.mkdir()
    for path in (here, there):
        path.write_text("!go.")
    base = fingerprint([here], SPACE, QLearning(), 0)
    assert fingerprint([there], SPACE, QLearning(), 0) == base
    others = {
        fingerprint([here, there], SPACE, QLearning(), 0),
        fingerprint([here], replace(SPACE, naming=()), QLearning(), 0),
        fingerprint([here], replace(SPACE, neutral=()), QLearning(), 0),
        fingerprint([here], None, QLearning(), 0),
        fingerprint([here], SPACE, QLearning(gamma=0.2), 0),
        fingerprint([here], SPACE, QLearning(), 1),
        fingerprint([here], SPACE, QLearning(), 0, version="0"),
    }
    here.write_text("!stay.")
    others.add(fingerprint([here], SPACE, QLearning(), 0))
    assert len(others | {base}) == 9


def test_a_fingerprint_of_no_file_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(GenerateError, match=r"gone\.asl: .*expected a readable file"):
        fingerprint([tmp_path / "gone.asl"], SPACE, None, 0)
