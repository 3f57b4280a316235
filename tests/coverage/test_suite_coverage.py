"""Coverage of a suite: totals, what is reachable, wrong waivers, curves, plans."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.coverage.code_map import Bits, CodeMap, CoverageError, map_code
from pytest_hricdv.coverage.records import CodeCoverage, PlanCoverage, PlanReach, SuiteCode
from pytest_hricdv.coverage.suite_coverage import (
    RunCoverage,
    TestCoverage,
    code_coverage,
    curve,
    file_coverage,
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


def test_reachable_is_all_but_the_waived(code: CodeMap) -> None:
    covered = code_coverage(code, lines(code, 3, 6, 7, 8, 9, 10, 11, 14)).statements
    assert covered == CodeCoverage(covered=8, total=9, reachable=8, percent=88.89, percent_reachable=100.0)


def test_a_waived_statement_that_runs_is_an_error(code: CodeMap) -> None:
    with pytest.raises(CoverageError, match=r"closed/__init__.py:15: ran, though it is waived as unreachable"):
        code_coverage(code, lines(code, 15))


def test_unmeasured_is_not_zero(code: CodeMap) -> None:
    assert code_coverage(code, None) == SuiteCode(statements=None, branches=None)
    only_lines = code.translate({str(code.files[0].path): [3]}, None)
    assert code_coverage(code, only_lines).branches is None
    assert file_coverage(code, None) == ()


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


@given(covers)
def test_the_curve_never_falls_and_ends_at_the_total(tests: list[TestCoverage]) -> None:
    points = curve(tests)
    for before, after in itertools.pairwise(points):
        assert all(getattr(before, key) <= getattr(after, key) for key in ("tests", "statements", "branches", "plans"))
    if points:
        total = union(tests)
        assert points[-1].statements == (total.statements.bit_count() if total else 0)


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
