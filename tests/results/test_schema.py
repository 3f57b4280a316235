"""The JSON Schema that ships, and the types that read a report: both refuse what breaks the contract."""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.results.codec import ReportError, load
from pytest_hricdv.results.model import Report, TestResult
from tests import json_schema
from tests.report import sample

GOOD = sample.data(tests=2)

Data = dict[str, Any]


def refusal(data: object, folder: Path) -> str:
    """What reading says of data that is no report; empty where it reads it."""
    (folder / "report.json").write_text(json.dumps(data), encoding="utf-8")
    try:
        load(folder)
    except ReportError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("data", [GOOD, sample.data(("by-hand", "rl"), 20), sample.data(tests=0)])
def test_a_good_report_keeps_the_schema(data: Data) -> None:
    json_schema.REPORT.validate(data)


def test_extra_keys_are_allowed(tmp_path: Path) -> None:
    data = {**GOOD, "host": {"cores": 2}}
    json_schema.REPORT.validate(data)
    assert refusal(data, tmp_path) == ""


def _properties(described: dict[str, Any], root: dict[str, Any], place: str = "$") -> Iterator[str]:
    """The places of all properties that a schema describes; test results in test results are not followed."""
    for choice in described.get("anyOf", ()):
        yield from _properties(choice, root, place)
    if "$ref" in described:
        described = root["$defs"][described["$ref"].removeprefix("#/$defs/")]
    for name, inner in described.get("properties", {}).items():
        yield f"{place}.{name}"
        if name != "repeats":
            yield from _properties(inner, root, f"{place}.{name}")
    for keyword, sign in (("additionalProperties", ".*"), ("items", "[]")):
        if isinstance(described.get(keyword), dict):
            yield from _properties(described[keyword], root, place + sign)


def test_schema_and_types_have_the_same_properties() -> None:
    (typed,), definitions = msgspec.json.schema_components([Report], ref_template="#/$defs/{name}")
    of_types = set(_properties(typed, {"$defs": definitions}))
    schema: Any = json_schema.REPORT.schema
    keys = {*Report.__struct_fields__, *(f"tests[].{name}" for name in TestResult.__struct_fields__)}
    # The schema also describes keys of optional parts; of parts that were taken out, types know nothing.
    described = {place for place in _properties(schema, schema) if _key(place) in keys}
    assert of_types == described


def _key(place: str) -> str:
    """`plan` of `$.plan[].title`, and `tests[].film` of `$.tests[].film.video`."""
    first, _, rest = place.removeprefix("$.").partition(".")
    name = re.split(r"[\[.]", first)[0]
    return f"tests[].{re.split(r'[.[]', rest)[0]}" if name == "tests" and rest else name


def _drop(*path: str | int) -> Callable[[Data], None]:
    def change(data: Any) -> None:
        for step in path[:-1]:
            data = data[step]
        del data[path[-1]]

    return change


def _put(value: object, *path: str | int) -> Callable[[Data], None]:
    def change(data: Any) -> None:
        for step in path[:-1]:
            data = data[step]
        data[path[-1]] = value

    return change


BAD = {
    "other version": (_put("hricdv-report/2", "schema"), "expected schema 'hricdv-report/3'"),
    "no tests": (_drop("tests"), "missing required field `tests`"),
    "count as text": (_put("134", "selected"), "Expected `int`, got `str` - at `$.selected`"),
    "negative count": (
        _put(-1, "suites", 0, "requirements", "R1", "nc"),
        "Expected `int` >= 0 - at `$.suites[0].requirements[...].nc`",
    ),
    "truth as count": (_put(True, "reported"), "Expected `int`, got `bool` - at `$.reported`"),
    "no verdict": (
        _drop("tests", 1, "requirements", "R3", "verdict"),
        "missing required field `verdict` - at `$.tests[1].requirements[...]`",
    ),
    "unknown verdict": (
        _put("passed", "tests", 0, "requirements", "R1", "verdict"),
        "Invalid enum value 'passed' - at `$.tests[0].requirements[...].verdict`",
    ),
    "unknown outcome": (_put("ok", "tests", 0, "outcome"), "Invalid enum value 'ok' - at `$.tests[0].outcome`"),
    "over 100 %": (
        _put(100.5, "suites", 0, "code", "statements", "percent"),
        "Expected `float` <= 100.0 - at `$.suites[0].code.statements.percent`",
    ),
    "half a branch": (
        _put([58], "code_under_test", "files", 0, "missing_branches", 0),
        "Expected `array` of length 2 - at `$.code_under_test.files[0].missing_branches[0]`",
    ),
    "no curve": (_drop("suites", 0, "curve"), "missing required field `curve` - at `$.suites[0]`"),
    "id with a path": (
        _put("../../victim/x", "tests", 0, "id"),
        "Expected `str` matching regex '^[A-Za-z0-9_-]+\\\\Z' - at `$.tests[0].id`",
    ),
    "link that runs": (
        _put({"file": "javascript:alert(1)"}, "tests", 0, "trace"),
        "- at `$.tests[0].trace.file`",
    ),
    "option that empties a folder": (
        _put(["--basetemp=/home"], "rerun_options", "options"),
        "- at `$.rerun_options.options[0]`",
    ),
    "plans as count": (
        _put(46, "suites", 0, "plans", "human", "covered"),
        "Expected `array`, got `int` - at `$.suites[0].plans[...].covered`",
    ),
}


@pytest.mark.parametrize(("change", "message"), BAD.values(), ids=BAD.keys())
def test_a_bad_report_is_refused_with_its_place(change: Callable[[Data], None], message: str, tmp_path: Path) -> None:
    data = copy.deepcopy(GOOD)
    change(data)
    assert not json_schema.REPORT.is_valid(data)
    assert message in refusal(data, tmp_path)


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


@given(place=st.sampled_from(PLACES), value=VALUES, drop=st.booleans())
def test_what_the_types_accept_keeps_the_schema(
    tmp_path_factory: pytest.TempPathFactory, place: tuple[str | int, ...], value: object, drop: bool
) -> None:
    data = copy.deepcopy(SMALL)
    (_drop(*place) if drop else _put(value, *place))(data)
    accepted = not refusal(data, tmp_path_factory.mktemp("report"))
    assert json_schema.REPORT.is_valid(data) or not accepted
