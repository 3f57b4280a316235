"""The verification plan in the terminal and on the page."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.extra.verification_plan.records import PLAN, PlanFeature, PlanState
from pytest_hricdv.report.formatting import Line, Style, plural
from pytest_hricdv.report.view import PageSection, SheetTable, View
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

    def of_sheet(self, report: Report) -> SheetTable | None:
        """The goals, each with its owner, or that of its section."""
        if not PLAN.of(report):
            return None
        rows = [(part.title or part.name, owner, part.state, _lacking(part)) for part, owner in _owned(report)]
        return SheetTable("Plan", _headline(PLAN.of(report)[0]), ("Goal", "Owner", "State", "Missing"), tuple(rows))

    def section(self, report: Report) -> PageSection | None:
        """The plan as a table: each goal with its owner, or that of its section."""
        if not PLAN.of(report):
            return None
        rows = [{"goal": goal, "owner": owner, "style": _STYLES[goal.state]} for goal, owner in _owned(report)]
        values = {"whole": PLAN.of(report)[0], "rows": rows}
        headline = _headline(PLAN.of(report)[0])
        return PageSection(
            "plan", "Plan", "verification_plan/plan.html.jinja", values, place="requirements", headline=headline
        )


VIEW = PlanView()


def _owned(report: Report) -> Iterator[tuple[PlanFeature, str]]:
    """The parts of the plan, each with who answers for it, or for its section."""
    owners = [""]
    for number, part in enumerate(PLAN.of(report)):
        owners = [*owners[: part.depth + 1], part.owner or owners[part.depth]]
        if number:  # the first is the plan itself
            yield part, owners[-1]


def _lacking(part: PlanFeature) -> str:
    """What a goal lacks; of a section, how many of its goals are met."""
    return "; ".join(part.missing) if part.is_goal else f"section: {part.met} of {plural(part.goals, 'goal')} met"


def _headline(whole: PlanFeature) -> str:
    return f"plan: {whole.met} of {plural(whole.goals, 'goal')} met ({whole.title})"
