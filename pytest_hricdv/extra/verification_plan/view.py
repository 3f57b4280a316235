"""The verification plan in the terminal and on the page."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pytest_hricdv.extra.verification_plan.records import PlanState
from pytest_hricdv.report.formatting import Line, Style, plural
from pytest_hricdv.results.model import Report

_MOST = 8
_STYLES: dict[PlanState, Style] = {
    "met": "ok",
    "waived": "warn",
    "open": "warn",
    "not checked": "warn",
    "failed": "bad",
}


def lines(report: Report) -> Iterator[Line]:
    """How many goals are met, and what the others lack."""
    if not report.plan:
        return
    whole, *parts = report.plan
    yield Line(f"plan: {whole.met} of {plural(whole.goals, 'goal')} met ({whole.title})", _STYLES[whole.state])
    lacking = [part for part in parts if part.is_goal and part.state not in ("met", "waived")]
    for part in sorted(lacking, key=lambda part: part.state != "failed")[:_MOST]:
        yield Line(f"  {part.state}  {part.name}: {'; '.join(part.missing)}", _STYLES[part.state])
    if len(lacking) > _MOST:
        yield Line(f"  and {plural(len(lacking) - _MOST, 'more goal')}: see the report", "dim")


def page(report: Report) -> list[dict[str, Any]]:
    """The rows of the page below the first part: each part, its owner or that of the section, and its style."""
    rows, owners = [], [""]
    for part in report.plan:
        owners = [*owners[: part.depth + 1], part.owner or owners[part.depth]]
        rows.append({"part": part, "owner": owners[-1], "style": _STYLES[part.state]})
    return rows[1:]
