"""Reading refuses what is no report, with file and place; writing refuses what has no JSON."""

from __future__ import annotations

import math
from enum import StrEnum
from pathlib import Path

import pytest

from pytest_hricdv.results.codec import ReportError, canonical, decode, encode, load
from pytest_hricdv.results.model import ConcreteParameters, TestResult


def result(**changes: object) -> TestResult:
    """A test that was not run."""
    fields: dict[str, object] = {
        "nodeid": "test_toy.py::test_toy[rl-leg1]",
        "suite": "rl",
        "id": "rl-leg1",
        "target": "",
        "name": "",
        "beliefs": ("leg1",),
        "abstract": ("wave",),
        "concrete": ConcreteParameters(actions=(), run={}),
        "seed": 0,
        "plans": {},
        "outcome": "not-run",
        "wall_s": 0.0,
        "sim_s": 0.0,
        "skipped_s": 0.0,
        "fidelity": "",
        "end_reason": "",
        "outcomes": (),
        "requirements": {},
        "code": None,
        "timeline": None,
        "failure": "",
        "unmeasured": "",
    }
    return TestResult(**(fields | changes))  # type: ignore[arg-type]


def test_a_result_survives_its_encoding() -> None:
    assert decode(encode(result(failure="é\n"))) == result(failure="é\n")


class Reading(float):
    """A subclass of float, as numpy's is."""


class Word(StrEnum):
    RELEASED = "released"


def test_values_of_subclasses_are_written_as_json() -> None:
    """A testbench may report numpy's floats and enumerations."""
    concrete = ConcreteParameters(actions=(), run={"speed": Reading(0.5)})
    made = result(outcomes=(Word.RELEASED,), concrete=concrete)
    assert decode(encode(made)) == made
    assert '"outcomes": ["released"]' in canonical({"test": made})


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
def test_a_number_that_json_has_not_is_refused_with_its_place(number: float) -> None:
    with pytest.raises(ReportError, match=r"cannot write \$\.concrete\.run\.speed as JSON"):
        canonical(result(concrete=ConcreteParameters(actions=(), run={"speed": number})))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r":1:1: not JSON, perhaps cut off"),
        ('{"schema": "hricdv-report/3",\n "tests": [', r":2:12: not JSON, perhaps cut off"),
        ('{"x": ' + "[" * 100_000, "nested too deeply"),
        ("[]", "Expected `object`, got `array`"),
        ("{}", "expected schema 'hricdv-report/3', found None"),
        ('{"schema": "hricdv-report/1"}', "found 'hricdv-report/1': run the suite again, or read the report with"),
        ('{"schema": "hricdv-report/9"}', "expected schema 'hricdv-report/3', found 'hricdv-report/9'"),
        ('{"schema": "hricdv-report/3"}', "Object missing required field `version`"),
        ('{"schema": "hricdv-report/3", "wall_s": NaN}', r":1:41: expected a finite number, got NaN"),
        (
            '{"schema": "hricdv-report/3", "tests": [{"outcomes": [1]}]}',
            r"Expected `str`, got `int` - at `\$\.tests\[0\]\.outcomes\[0\]`",
        ),
    ],
)
def test_what_is_no_report_is_refused_with_its_place(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "report.json"
    path.write_text(text)
    with pytest.raises(ReportError, match=message) as raised:
        load(tmp_path)
    assert str(raised.value).startswith(str(path))
