"""Merging: a union that depends neither on the order nor on how often, and exact to the byte."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import convert, json
from msgspec.structs import replace

from pytest_hricdv.coverage.records import CodeShare
from pytest_hricdv.extra.closing.records import CLOSING, ClosingResult
from pytest_hricdv.results.codec import canonical
from pytest_hricdv.results.merging import MergeError, count_expected, list_missing_shards, merge
from pytest_hricdv.results.model import Report, RequirementText, TestResult
from tests import json_schema
from tests.report import sample_sections
from tests.results import reports as made


def merged(*several: Report) -> Report:
    return merge([(f"report {n}", report) for n, report in enumerate(several)])


@given(made.reports(), made.reports())
def test_the_same_report_twice_is_once(a: Report, b: Report) -> None:
    assert canonical(merged(a, a)) == canonical(merged(a))
    assert canonical(merged(a, b, b)) == canonical(merged(a, b))
    assert canonical(merged(merged(a, b), a)) == canonical(merged(a, b))


@given(st.tuples(*(made.tests(number) for number in range(1, made.SIZE + 1))), st.lists(st.integers(0, 2), min_size=6))
def test_parts_make_the_whole(tests: tuple[TestResult, ...], parts: list[int]) -> None:
    shards = [
        made.report([test for test, home in zip(tests, parts, strict=False) if home == part], shard=f"{part + 1}/3")
        for part in range(3)
    ]
    together, whole = merged(*shards), made.report(tests)
    for key in ("tests", "selected", "reported", "not_run", "not_run_tests"):
        assert getattr(together, key) == getattr(whole, key)
    reason = together.code_under_test.reason
    assert together.code_under_test == replace(whole.code_under_test, reason=reason)
    timeless = [replace(report.suites[0], generation=whole.suites[0].generation) for report in (together, whole)]
    assert timeless[0] == timeless[1]
    assert count_expected(together) == made.SIZE
    assert list_missing_shards(together) == ()
    assert list_missing_shards(merged(*shards[1:])) == ("1/3",)


@given(made.reports(), made.reports())
def test_a_merged_report_keeps_the_contract_and_loses_nothing(a: Report, b: Report) -> None:
    both = merged(a, b)
    json_schema.REPORT.validate(json.decode(canonical(both)))
    assert json.decode(canonical(both), type=Report) == both
    assert {test.nodeid for test in both.tests} == {test.nodeid for report in (a, b) for test in report.tests}
    was_run = {test.nodeid for report in (a, b) for test in report.tests if test.outcome != "not-run"}
    assert {test.nodeid for test in both.tests if test.outcome != "not-run"} == was_run
    for kind in ("statements", "branches"):
        covered = getattr(both.suites[0].code, kind)
        before = [getattr(report.suites[0].code, kind) for report in (a, b)]
        if covered is not None:
            assert covered.covered >= max((code.covered for code in before if code), default=0)
        elif kind == "statements":
            assert before == [None, None]


def run(number: int, outcome: int) -> TestResult:
    """A run of a test, by its outcome: 0 passed, 2 failed."""
    judged = made.verdict("Failed" if outcome else "Passed")
    return made.result(
        number,
        outcome=("passed", "known-violation", "failed")[outcome],
        wall_s=1.0,
        sim_s=1.0,
        plans={"human": ("p", "q", "r")[outcome : outcome + 1]},
        cross={"turn": (("1", "kept"),) if outcome else ()},
        requirements={"R1": judged, "R2": judged},
        code=CodeShare(statements=1, percent=20.0, bits=(hex(1 << outcome), "0x0")),
    )


def test_of_runs_that_differ_the_worst_stands_for_the_test_and_all_of_them_cover() -> None:
    both = merged(made.report([run(1, 0)]), made.report([run(1, 2)], 2.0), made.report([run(1, 0)], 3.0))
    (test,) = both.tests
    assert test.outcome == "failed"
    assert [run.outcome for run in test.repeats] == ["passed"]
    (suite,) = both.suites
    assert suite.requirements["R1"].failed == 1
    assert suite.requirements["R1"].passed == 0
    assert suite.code.statements is not None
    assert suite.code.statements.covered == 2
    assert suite.plans["human"].covered == ("p", "r")
    assert suite.cross.hit == 1
    assert sorted(session.wall_s for session in both.sessions) == [1.0, 2.0, 3.0]
    assert both.wall_s == 6.0


MINE = made.report([])
SUITE = MINE.suites[0]
OTHER_MODEL = {"human": replace(MINE.models["human"], source="@q +!g.")}
OTHER_TITLE = {**MINE.requirements, "R2": RequirementText(title="?", source="", text="")}
OTHER_GENERATION = replace(SUITE.generation, bdi_runs=9)
BAD = {
    "other code": (
        replace(MINE, code_under_test=replace(MINE.code_under_test, sha256="77", map=made.CODE.map[:1])),
        r"mine and other: different code under test: robot/b\.py; run both again",
    ),
    "other version": (replace(MINE, version="0.9"), "mine and other: different version: '0.1.0' and '0.9'"),
    "other testbench": (replace(MINE, testbench="chair"), "different testbench: 'toy' and 'chair'"),
    "other requirements": (replace(MINE, requirements=OTHER_TITLE), "different requirements: R2"),
    "other known violations": (replace(MINE, known_violations={}), "different known violations: R2"),
    "other model": (replace(MINE, models=OTHER_MODEL), "different BDI models"),
    "other products": (replace(MINE, cross_products={}), "declared different cross products"),
    "other seed": (
        replace(MINE, suites=(replace(SUITE, seed=5),)),
        "two suites have the name 'rl' but another seed; merge runs of one",
    ),
    "other suite": (
        replace(MINE, suites=(replace(SUITE, generation=OTHER_GENERATION),)),
        "the name 'rl' but other tests or options",
    ),
}


@pytest.mark.parametrize(("other", "message"), BAD.values(), ids=BAD.keys())
def test_reports_that_do_not_belong_together_are_refused(other: Report, message: str) -> None:
    with pytest.raises(MergeError, match=message):
        merge([("mine", MINE), ("other", other)])


def test_what_a_closing_loop_has_shown_stays_where_all_sessions_have_the_same() -> None:
    shards = [
        replace(MINE, closing=convert(sample_sections.CLOSING, ClosingResult), shard=f"{part}/2") for part in (1, 2)
    ]
    assert CLOSING.of(merged(*shards)) == CLOSING.of(shards[0])
    assert CLOSING.of(merged(shards[0], replace(shards[1], closing=None))) is None
