"""Margins in words: how far from its bound a requirement was, with the unit."""

from __future__ import annotations

import re
from collections.abc import Mapping

from pytest_hricdv.report.formatting import quantity
from pytest_hricdv.results.model import Report, RequirementText

NO_TEXT = RequirementText(title="", source="", text="")


def unit_of(formula: str, units: Mapping[str, str]) -> str:
    """The unit of a requirement's margins: seconds for a deadline, else that of the signals it compares.

    Args:
        formula: the requirement's text; where its pattern names no signal with a unit, or several units, there is none.
        units: signal or `topic.field` -> unit.
    """
    response = formula.partition("->")[2]
    if "eventually" in response:
        return "s"
    named = {units[word] for word in re.findall(r"[A-Za-z_][\w.]*", response) if word in units}
    return named.pop() if len(named) == 1 else ""


def margin_unit(report: Report, requirement: str) -> str:
    """The unit of a requirement's margins in a report; empty where that is not known."""
    return unit_of(report.requirements.get(requirement, NO_TEXT).text, report.units or {})


def margin_text(margin: float, unit: str, digits: str = "") -> str:
    """`-0.02 m`, or with a format such as ".3g"."""
    return f"{format(margin, digits) if digits else quantity(margin)} {unit}".rstrip()
