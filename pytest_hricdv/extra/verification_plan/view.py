"""The verification plan in the terminal and on the page."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.extra.verification_plan.records import PLAN, PlanPart, PlanState
from pytest_hricdv.report.formatting import Line, Style, plural
from pytest_hricdv.report.view import PageSection, View
from pytest_hricdv.results.model import Report

_MOST = 8
_STYLES: dict[PlanState, Style] = {
    "met": "ok",
    "waived": "warn",
    "open": "warn",
    "not checked": "warn",
    "failed": "bad",
}


class PlanView(View):
    """How many goals are met, and what the others lack."""

    name = "verification_plan"

    def lines(self, report: Report, columns: int) -> Iterator[Line]:
        """The goals that are not met, at most some of them."""
        if not PLAN.of(report):
            return
        whole, *parts = PLAN.of(report)
        yield Line(_headline(whole), _STYLES[whole.state])
        lacking = [part for part in parts if part.is_goal and part.state not in ("met", "waived")]
        for part in sorted(lacking, key=lambda part: part.state != "failed")[:_MOST]:
            yield Line(f"  {part.state}  {part.name}: {'; '.join(part.missing)}", _STYLES[part.state])
        if len(lacking) > _MOST:
            yield Line(f"  and {plural(len(lacking) - _MOST, 'more goal')}: see the report", "dim")

    def section(self, report: Report) -> PageSection | None:
        """The plan as a table: each goal with its owner, or that of its section."""
        if not PLAN.of(report):
            return None
        rows, owners = [], [""]
        for goal in PLAN.of(report):
            owners = [*owners[: goal.depth + 1], goal.owner or owners[goal.depth]]
            rows.append({"goal": goal, "owner": owners[-1], "style": _STYLES[goal.state]})
        values = {"whole": PLAN.of(report)[0], "rows": rows[1:]}
        headline = _headline(PLAN.of(report)[0])
        return PageSection(
            "plan", "Plan", "verification_plan/plan.html.jinja", values, place="requirements", headline=headline
        )


VIEW = PlanView()


def _headline(whole: PlanPart) -> str:
    return f"plan: {whole.met} of {plural(whole.goals, 'goal')} met ({whole.title})"
