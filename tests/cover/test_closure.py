"""Closure: totals, reachable, waivers that break, curves, cross products."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.cover.closure import TestCover, code_closure, curve, files, plan_closure, union
from pytest_hricdv.cover.source import Bits, CodeMap, CoverError, map_code
from tests.cover.project import write_package


@pytest.fixture
def code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> CodeMap:
    write_package(tmp_path, "closed")
    monkeypatch.syspath_prepend(str(tmp_path))
    return map_code(["closed"], tmp_path)


def lines(code: CodeMap, *numbers: int) -> Bits:
    return code.translated({str(code.files[0].path): numbers}, {})


def test_reachable_is_all_but_the_waived(code: CodeMap) -> None:
    closure = code_closure(code, lines(code, 3, 6, 7, 8, 9, 10, 11, 14))["statements"]
    assert closure is not None
    assert closure == {"covered": 8, "total": 9, "reachable": 8, "percent": 88.89, "percent_reachable": 100.0}


def test_a_waived_statement_that_runs_is_an_error(code: CodeMap) -> None:
    with pytest.raises(CoverError, match=r"closed/__init__.py:15: ran, though it is waived as unreachable"):
        code_closure(code, lines(code, 15))


def test_unmeasured_is_not_zero(code: CodeMap) -> None:
    assert code_closure(code, None) == {"statements": None, "branches": None}
    only_lines = code.translated({str(code.files[0].path): [3]}, None)
    assert code_closure(code, only_lines)["branches"] is None
    assert files(code, None) == []


covers = st.lists(
    st.builds(
        TestCover,
        id=st.text("abc", min_size=1, max_size=3),
        code=st.one_of(st.none(), st.builds(Bits, st.integers(0, 255), st.integers(0, 15))),
        plans=st.fixed_dictionaries({"human": st.frozensets(st.sampled_from("pqr"))}),
    ),
    max_size=8,
    unique_by=lambda cover: cover.id,
)


@given(covers, st.randoms())
def test_totals_and_curve_do_not_depend_on_the_order_of_tests(tests: list[TestCover], random: object) -> None:
    shuffled = list(tests)
    random.shuffle(shuffled)  # type: ignore[attr-defined]
    assert union(tests) == union(shuffled)
    assert curve(tests) == curve(shuffled)
    labels = {"human": ["p", "q", "r", "s"]}
    assert plan_closure(tests, labels) == plan_closure(shuffled, labels)


@given(covers)
def test_the_curve_never_falls_and_ends_at_the_total(tests: list[TestCover]) -> None:
    points = curve(tests)
    for before, after in itertools.pairwise(points):
        assert all(before[key] <= after[key] for key in ("tests", "statements", "branches", "plans"))
    if points:
        total = union(tests)
        assert points[-1]["statements"] == (total.statements.bit_count() if total else 0)


def test_plans_are_listed_in_source_order_with_who_reaches_them() -> None:
    tests = [
        TestCover("a", None, {"human": frozenset({"plan2"})}, ("bored", "leg1")),
        TestCover("b", None, {"human": frozenset({"plan2", "plan1"})}, ("leg1",)),
        TestCover("c", None, {"human": frozenset({"plan1"})}),
        TestCover("d", None, {}),
    ]
    closure = plan_closure(tests, {"human": ["plan1", "plan2", "plan10"]})
    assert closure == {
        "human": {
            "covered": ["plan1", "plan2"],
            "missing": ["plan10"],
            "total": 3,
            "declared": ["plan1", "plan2", "plan10"],
            "reached": {
                "plan1": {"tests": 2, "belief_sets": 1, "shortest": ["leg1"], "test": "b"},
                "plan2": {"tests": 2, "belief_sets": 2, "shortest": ["leg1"], "test": "b"},
            },
        }
    }
