"""Coverage of a suite: totals, what is reachable, wrong waivers, curves, plans."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.coverage.code_map import Bits, CodeMap, CoverageError, map_code
from pytest_hricdv.coverage.records import PlanCoverage, PlanReach
from pytest_hricdv.coverage.suite_coverage import (
    RunCoverage,
    TestCoverage,
    code_coverage,
    curve,
    plan_coverage,
    union,
)
from tests.coverage.project import write_package


@pytest.fixture
def code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> CodeMap:
    write_package(tmp_path, "closed")
    monkeypatch.syspath_prepend(str(tmp_path))
    return map_code(["closed"], tmp_path)


def lines(code: CodeMap, *numbers: int) -> Bits:
    return code.translate({str(code.files[0].path): numbers}, {})


def test_a_waived_statement_that_runs_is_an_error(code: CodeMap) -> None:
    with pytest.raises(CoverageError, match=r"closed/__init__.py:15: ran, though it is waived as unreachable"):
        code_coverage(code, lines(code, 15))


def covering(
    id: str, code: Bits | None = None, plans: Mapping[str, frozenset[str]] | None = None, beliefs: tuple[str, ...] = ()
) -> TestCoverage:
    return TestCoverage(f"t[{id}]", (RunCoverage(id, code, plans or {}, beliefs),))


covers = st.lists(
    st.builds(
        covering,
        st.text("abc", min_size=1, max_size=3),
        code=st.one_of(st.none(), st.builds(Bits, st.integers(0, 255), st.integers(0, 15))),
        plans=st.fixed_dictionaries({"human": st.frozensets(st.sampled_from("pqr"))}),
    ),
    max_size=8,
    unique_by=lambda cover: cover.id,
)


@given(covers, st.randoms())
def test_totals_and_curve_do_not_depend_on_the_order_of_tests(tests: list[TestCoverage], random: object) -> None:
    shuffled = list(tests)
    random.shuffle(shuffled)  # type: ignore[attr-defined]
    assert union(tests) == union(shuffled)
    assert curve(tests) == curve(shuffled)
    labels = {"human": ["p", "q", "r", "s"]}
    assert plan_coverage(tests, labels) == plan_coverage(shuffled, labels)


def test_plans_are_listed_in_source_order_with_who_reaches_them() -> None:
    tests = [
        covering("a", None, {"human": frozenset({"plan2"})}, ("bored", "leg1")),
        covering("b", None, {"human": frozenset({"plan2", "plan1"})}, ("leg1",)),
        covering("c", None, {"human": frozenset({"plan1"})}),
        covering("d"),
    ]
    assert plan_coverage(tests, {"human": ["plan1", "plan2", "plan10"]}) == {
        "human": PlanCoverage(
            covered=("plan1", "plan2"),
            missing=("plan10",),
            total=3,
            declared=("plan1", "plan2", "plan10"),
            reached={
                "plan1": PlanReach(tests=2, belief_sets=1, shortest=("leg1",), test="b"),
                "plan2": PlanReach(tests=2, belief_sets=2, shortest=("leg1",), test="b"),
            },
        )
    }
