"""Typed reports and results from the JSON data that a session still builds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from msgspec import convert

from pytest_hricdv.results.model import Report, RequirementText, TestResult

_UNFINISHED = {"outcome": "not-run", "wall_s": None, "failure": "", "unmeasured": ""}


def typed_report(data: Mapping[str, Any]) -> Report:
    """The report of this data."""
    return convert(data, Report)


def typed_result(entry: Mapping[str, Any]) -> TestResult:
    """The result of a test, whose outcome may not be known yet."""
    return convert({**_UNFINISHED, **entry}, TestResult)


def typed_texts(texts: Mapping[str, Any]) -> dict[str, RequirementText]:
    """Requirement -> its texts."""
    return convert(texts, dict[str, RequirementText])
