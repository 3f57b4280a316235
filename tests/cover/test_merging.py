"""Merging: a union that depends neither on the order nor on how often, and exact to the byte."""

from __future__ import annotations

import copy
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pytest_hricdv.closure.closing import close
from pytest_hricdv.closure.merging import MergeError, expected, merge, missing_shards
from pytest_hricdv.report.contract import faults
from pytest_hricdv.results.codec import canonical
from tests.cover import reports as made
from tests.cover.reports import Report

few = settings(max_examples=40, deadline=None)


def merged(*several: Report) -> Report:
    return merge([(f"report {n}", copy.deepcopy(each)) for n, each in enumerate(several)])


@few
@given(made.reports(), made.reports())
def test_the_order_makes_no_difference(a: Report, b: Report) -> None:
    assert canonical(merged(a, b)) == canonical(merged(b, a))


@few
@given(made.reports(), made.reports(), made.reports())
def test_what_is_merged_first_makes_no_difference(a: Report, b: Report, c: Report) -> None:
    whole = canonical(merged(a, b, c))
    assert canonical(merged(merged(a, b), c)) == whole
    assert canonical(merged(a, merged(b, c))) == whole


@few
@given(made.reports(), made.reports())
def test_the_same_report_twice_is_once(a: Report, b: Report) -> None:
    assert canonical(merged(a, a)) == canonical(merged(a))
    assert canonical(merged(a, b, b)) == canonical(merged(a, b))
    assert canonical(merged(merged(a, b), a)) == canonical(merged(a, b))


@few
@given(st.tuples(*(made.tests(number) for number in range(1, made.SIZE + 1))), st.lists(st.integers(0, 2), min_size=6))
def test_parts_make_the_whole(tests: tuple[Report, ...], parts: list[int]) -> None:
    shards = [
        made.report([test for test, home in zip(tests, parts, strict=False) if home == part], shard=f"{part + 1}/3")
        for part in range(3)
    ]
    together, whole = merged(*shards), made.report(list(tests))
    for key in ("tests", "selected", "reported", "not_run", "not_run_tests"):
        assert together[key] == whole[key]
    assert together["code_under_test"] == whole["code_under_test"] | {"reason": together["code_under_test"]["reason"]}
    timeless = [{key: value for key, value in r["suites"][0].items() if key != "generation"} for r in (together, whole)]
    assert timeless[0] == timeless[1]
    assert expected(together) == made.SIZE
    assert missing_shards(together) == ()
    assert missing_shards(merged(*shards[1:])) == ("1/3",)


@few
@given(made.reports(), made.reports())
def test_a_merged_report_keeps_the_contract_and_loses_nothing(a: Report, b: Report) -> None:
    both = merged(a, b)
    assert faults(both) == []
    assert {test["nodeid"] for test in both["tests"]} == {test["nodeid"] for r in (a, b) for test in r["tests"]}
    reached = [test["nodeid"] for test in both["tests"] if test["outcome"] != "not-run"]
    assert set(reached) == {test["nodeid"] for r in (a, b) for test in r["tests"] if test["outcome"] != "not-run"}
    for kind in ("statements", "branches"):
        figures = both["suites"][0]["code"][kind]
        before = [r["suites"][0]["code"][kind] for r in (a, b)]
        if figures is not None:
            assert figures["covered"] >= max((each["covered"] for each in before if each), default=0)
        elif kind == "statements":
            assert before == [None, None]


def run(number: int, outcome: int) -> Report:
    """A run of a test, by how it went: 0 passed, 2 failed."""
    code = {"statements": 1, "percent": 20.0, "bits": [hex(1 << outcome), "0x0"]}
    return {
        "nodeid": f"t[{number}]",
        "suite": "rl",
        "id": f"t{number}",
        "beliefs": ["leg1"],
        "abstract": [],
        "concrete": None,
        "seed": number,
        "outcome": ("passed", "known-violation", "failed")[outcome],
        "wall_s": 1.0,
        "sim_s": 1.0,
        "frozen_s": 0.0,
        "fidelity": "",
        "legs": [],
        "plans": {"human": ["p", "q", "r"][outcome : outcome + 1]},
        "cross": {"turn": [["1", "kept"]] if outcome else []},
        "requirements": {name: made.verdict("Failed" if outcome else "Passed") for name in ("R1", "R2")},
        "code": code,
        "unmeasured": "",
        "failure": "",
    }


def test_of_runs_that_differ_the_worst_stands_for_the_test_and_all_of_them_cover() -> None:
    both = merged(made.report([run(1, 0)]), made.report([run(1, 2)], 2.0), made.report([run(1, 0)], 3.0))
    (test,) = both["tests"]
    assert test["outcome"] == "failed"
    assert [each["outcome"] for each in test["repeats"]] == ["passed"]
    (suite,) = both["suites"]
    assert suite["requirements"]["R1"]["failed"] == 1
    assert suite["requirements"]["R1"]["passed"] == 0
    assert suite["code"]["statements"]["covered"] == 2
    assert suite["plans"]["human"]["covered"] == ["p", "r"]
    assert suite["cross"]["hit"] == 1
    assert [each["wall_s"] for each in sorted(both["sessions"], key=lambda each: each["wall_s"])] == [1.0, 2.0, 3.0]
    assert both["wall_s"] == 6.0


def changed(path: str, value: Any) -> Report:
    """A report with another value at a place."""
    report = copy.deepcopy(made.report([]))
    *steps, last = path.split(".")
    place: Any = report
    for step in steps:
        place = place[int(step)] if step.isdigit() else place[step]
    if value is None:
        del place[last]
    else:
        place[last] = value
    return report


BAD = {
    "other code": (
        changed("code_under_test", {**made.CODE, "sha256": "77", "map": made.CODE["map"][:1]}),
        r"mine and other: different code under test: robot/b\.py; run both anew",
    ),
    "other version": (changed("version", "0.9"), "mine and other: different version: '0.1.0' and '0.9'"),
    "other testbench": (changed("testbench", "chair"), "different testbench: 'toy' and 'chair'"),
    "other requirements": (changed("requirements.R2", {"title": "?"}), "different requirements: R2"),
    "other known violations": (changed("known_violations", {}), "different known violations: R2"),
    "other model": (changed("models.human.source", "@q +!g."), "different BDI models"),
    "other products": (changed("cross_products", {}), "declared different cross products"),
    "other seed": (changed("suites.0.seed", 5), "two suites have the name 'rl' but another seed; merge runs of one"),
    "other suite": (
        changed("suites.0.generation.bdi_runs", 9),
        "the name 'rl' but other tests or options",
    ),
    "older": (changed("suites.0.size", None), r"other: report\.suites\[0\]: 'size' is missing: another version"),
    "no map": (changed("code_under_test.map", None), r"other: report\.code_under_test: 'map' is missing"),
}


@pytest.mark.parametrize(("other", "message"), BAD.values(), ids=BAD.keys())
def test_reports_that_do_not_belong_together_are_refused(other: Report, message: str) -> None:
    with pytest.raises(MergeError, match=message):
        merge([("mine", made.report([])), ("other", other)])


def test_nothing_to_merge_is_refused() -> None:
    with pytest.raises(MergeError, match="nothing to merge"):
        merge([])


def test_a_waived_line_that_ran_in_one_of_them_is_told() -> None:
    broken = made.report([])
    broken["tests"] = [run(1, 0) | {"code": {"statements": 1, "percent": 20.0, "bits": ["0x10", "0x0"]}}]
    with pytest.raises(MergeError, match=r"robot/b\.py:2: ran, though it is waived"):
        merge([("mine", broken)])


@few
@given(made.reports())
def test_closing_again_changes_nothing(a: Report) -> None:
    assert close(copy.deepcopy(a), a["code_under_test"]["reason"]) == a
