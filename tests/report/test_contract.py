"""The JSON Schema and the built-in check agree, and refuse what breaks the contract."""

import copy
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pytest_hricdv.report.contract import faults, schema
from tests.report import sample

VALIDATOR = jsonschema.Draft202012Validator(schema())
GOOD = sample.data(tests=2)

Report = dict[str, Any]


def test_schema_is_one() -> None:
    jsonschema.Draft202012Validator.check_schema(schema())


@pytest.mark.parametrize("report", [GOOD, sample.data(("by-hand", "rl"), 20), sample.data(tests=0)])
def test_good_report_keeps_the_contract(report: Report) -> None:
    VALIDATOR.validate(report)
    assert faults(report) == []


def test_extra_keys_are_allowed() -> None:
    assert faults({**GOOD, "host": {"cores": 2}}) == []


def test_optional_keys_may_be_absent() -> None:
    bare = {key: GOOD[key] for key in ("schema", "selected", "reported", "not_run", "suites", "tests")}
    VALIDATOR.validate(bare)
    assert faults(bare) == []


def _drop(*path: str | int) -> Callable[[Report], None]:
    def change(report: Any) -> None:
        for step in path[:-1]:
            report = report[step]
        del report[path[-1]]

    return change


def _put(value: object, *path: str | int) -> Callable[[Report], None]:
    def change(report: Any) -> None:
        for step in path[:-1]:
            report = report[step]
        report[path[-1]] = value

    return change


BAD = {
    "other version": (_put("hricdv-report/2", "schema"), "report.schema: expected 'hricdv-report/1'"),
    "no tests": (_drop("tests"), "report: 'tests' is missing"),
    "count as text": (_put("134", "selected"), "report.selected: expected integer, found '134'"),
    "negative count": (_put(-1, "suites", 0, "requirements", "R1", "nc"), "report.suites[0].requirements.R1.nc: -1"),
    "truth as count": (_put(True, "reported"), "report.reported: expected integer, found True"),
    "no verdict": (_drop("tests", 1, "requirements", "R3", "verdict"), "report.tests[1].requirements.R3: 'verdict'"),
    "unknown verdict": (
        _put("passed", "tests", 0, "requirements", "R1", "verdict"),
        "expected one of Passed, Failed, NC",
    ),
    "unknown outcome": (_put("ok", "tests", 0, "outcome"), "report.tests[0].outcome: expected one of passed, failed"),
    "over 100 %": (_put(100.5, "suites", 0, "code", "statements", "percent"), "100.5 is outside of 0 to 100"),
    "half a branch": (_put([58], "code_under_test", "files", 0, "missing_branches", 0), "1 items, expected 2 to 2"),
    "no curve": (_drop("suites", 0, "curve"), "report.suites[0]: 'curve' is missing"),
    "plans as count": (_put(46, "suites", 0, "plans", "human", "covered"), "report.suites[0].plans.human.covered"),
}


@pytest.mark.parametrize(("change", "message"), BAD.values(), ids=BAD.keys())
def test_bad_report_is_refused_with_its_place(change: Callable[[Report], None], message: str) -> None:
    report = copy.deepcopy(GOOD)
    change(report)
    assert not VALIDATOR.is_valid(report)
    assert message in "\n".join(faults(report))


@pytest.mark.parametrize("value", [float("nan"), [{"x": (1.0, float("inf"))}], {"y": [float("-inf")]}])
def test_a_number_that_is_none_is_found_where_nothing_else_is_asked(value: object) -> None:
    (found,) = faults(GOOD | {"more": value})
    assert found.startswith("report.more")


def test_not_a_report_is_refused() -> None:
    assert faults([1]) == ["report: expected object, found [1]"]


def _places(value: Any, path: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    steps = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for step, inner in steps:
        yield (*path, step)
        yield from _places(inner, (*path, step))


SMALL = sample.data(tests=1)
SMALL["suites"][0]["generation"]["q_delta"] = [1.0]
PLACES = sorted(_places(SMALL), key=str)
VALUES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 200),
    st.floats(-3, 200),
    st.sampled_from(["", "NC", "passed", "rl"]),
    st.just([]),
    st.just({}),
    st.just([1, 2]),
    st.just(["a"]),
    st.just({"a": 1}),
)


@settings(max_examples=150, deadline=None)
@given(place=st.sampled_from(PLACES), value=VALUES, drop=st.booleans())
def test_check_agrees_with_a_full_validator(place: tuple[str | int, ...], value: object, drop: bool) -> None:
    report = copy.deepcopy(SMALL)
    (_drop(*place) if drop else _put(value, *place))(report)
    assert (not faults(report)) == VALIDATOR.is_valid(report)


def test_schema_uses_only_keywords_that_the_check_knows() -> None:
    text = (Path(__file__).parents[2] / "pytest_hricdv/report/report-1.schema.json").read_text(encoding="utf-8")
    unknown = ("anyOf", "oneOf", "allOf", "not", "pattern", "format", "prefixItems", "uniqueItems", "if", "maxLength")
    assert not re.findall(rf'"({"|".join(unknown)})":', text)
