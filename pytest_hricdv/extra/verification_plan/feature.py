"""The verification plan in a session (`--hri-plan`): shows in report, terminal and page which of its goals are met.

`VerificationPlanFeature` reads it with `load_plan` and judges its goals with `evaluate`; `PlanView` shows them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec.structs import replace

from pytest_hricdv.extra.verification_plan.plan import (
    PLAN,
    STATES,
    PlanError,
    PlanItem,
    PlanState,
    Subjects,
    load_plan,
)
from pytest_hricdv.report.view import PageSection, SheetTable, View
from pytest_hricdv.session.feature import Feature, FeatureSession
from pytest_hricdv.session.option import OptionReader, Value, usage_error

if TYPE_CHECKING:
    from pytest_hricdv.report.formatting import Line, Style
    from pytest_hricdv.results.model import Report
    from pytest_hricdv.session.run_context import RunContext

SECTIONS = (PLAN,)


class VerificationPlanFeature(Feature[Path]):
    """Reports which goals of a verification plan are met."""

    name = "verification_plan"
    group = "verdict"
    options = (
        Value("plan", "FILE", "verification plan (TOML): report which of its goals are met, and what the others lack"),
    )

    def read(self, reader: OptionReader) -> Path | None:
        """The file of the plan."""
        return reader.file("plan")

    def check(self, context: RunContext) -> None:
        """Reads the plan, so that a mistake in it is found before the first test."""
        self._plan(context)

    def follow_up(self, context: RunContext) -> str:
        """The state of the plan, where there is one."""
        return "" if self.settings(context.options) is None else "the state of the plan (--hri-plan)"

    def after_gates(self, session: FeatureSession, report: Report) -> Report:
        """The report with the plan and its state."""
        if self.settings(session.options) is None:
            return report
        session.done.add(self.name)
        return PLAN.put(report, evaluate(self._plan(session.context), report))

    def _plan(self, context: RunContext) -> tuple[PlanItem, ...]:
        path = self.settings(context.options)
        if path is None:
            return ()
        testbench = context.collection.testbench
        requirements = [requirement.id for requirement in context.requirements]
        try:
            return load_plan(path, Subjects(requirements, testbench.cross, testbench.model.covered))
        except PlanError as error:
            raise usage_error(f"--hri-plan: {error}") from None


FEATURE = VerificationPlanFeature()


def merge(reports: Sequence[Report], merged: Report) -> Report:
    """The merged report with the state of the plan, where all reports have the same one."""
    plans = [[item.without_state() for item in PLAN.of(report)] for report in reports]
    return PLAN.put(merged, evaluate(plans[0], merged)) if all(plan == plans[0] for plan in plans) else merged


Finding = tuple[PlanState, str]
"""What one wish of a goal came to, and what is missing for it."""


def evaluate(plan: Sequence[PlanItem], report: Report) -> tuple[PlanItem, ...]:
    """The plan with the state of each goal, and what it lacks.

    Args:
        plan: its items, in the order of the file; their earlier states have no effect.
        report: the report of a session, or merged.
    """
    done: list[PlanItem] = []
    for part in reversed(plan):  # what a section has is known before it
        depth = part.depth
        inside = list(takewhile(lambda other, depth=depth: other.depth > depth, reversed(done)))  # type: ignore[misc]
        done.append(_goal(part, report) if part.is_goal else _section(part, inside))
    return tuple(reversed(done))


def _goal(goal: PlanItem, report: Report) -> PlanItem:
    findings = list(_check_goal(goal, report))
    state = max((state for state, _ in findings), key=STATES.index, default="open")
    missing = tuple(text for _, text in findings if text)
    return replace(goal, state=state, missing=missing, goals=1, met=int(state in ("met", "waived")))


def _section(section: PlanItem, inside: Sequence[PlanItem]) -> PlanItem:
    goals = [part for part in inside if part.is_goal]
    state = max((part.state for part in goals), key=STATES.index, default="open")
    return replace(section, state=state, goals=len(goals), met=sum(goal.met for goal in goals))


def _check_goal(goal: PlanItem, report: Report) -> Iterator[Finding]:
    from pytest_hricdv.results.derivation import code_covered

    for name in goal.requirements:
        yield _check_requirement(name, goal.triggers, report)
    for kind, wanted in (("statements", goal.statements), ("branches", goal.branches)):
        if wanted is not None:
            hit, total = code_covered(report, kind, goal.files)
            yield _check_share(kind, hit, total, wanted)
    for name, wanted in goal.cross.items():
        yield _check_share(name, *_cross(report, name), wanted)
    for agent, wanted in goal.plans.items():
        yield _check_share(f"plans of {agent}", *_plans(report, agent), wanted)


def _check_requirement(name: str, triggers: int, report: Report) -> Finding:
    tallies = [suite.requirements[name] for suite in report.suites if name in suite.requirements]
    failed = sum(tally.failed for tally in tallies)
    count = sum(tally.triggers for tally in tallies)
    if failed and (report.strict or name not in report.known_violations):
        return "failed", f"{name} failed in {failed} of {len(report.tests)} tests"
    if sum(tally.outside for tally in tallies):
        return "failed", f"{name} failed outside of the condition under which it is known to"
    if failed:
        return "waived", f"{name} is known to fail: {report.known_violations[name]}"
    if not sum(tally.passed for tally in tallies):
        if name in report.allowed_untriggered:
            return "waived", f"{name} need not be checked: {report.allowed_untriggered[name].reason}"
        return "not checked", f"{name} was not checked"
    if count < triggers:
        return "open", f"{name} was triggered {count} of {triggers} times"
    return "met", ""


def _check_share(name: str, hit: int, total: int, wanted: float) -> Finding:
    if not total:
        return "open", f"{name}: nothing was measured"
    percent = 100.0 * hit / total
    return (
        ("met", "")
        if percent >= wanted
        else ("open", f"{name}: {percent:.1f} % ({hit} of {total}), {wanted:g} % wanted")
    )


def _cross(report: Report, name: str) -> tuple[int, int]:
    """Hit and possible bins of a product, over all suites."""
    declared = report.cross_products[name]
    covered = [suite.cross.products[name] for suite in report.suites if name in suite.cross.products]
    illegal = {record.bin for record in declared.illegal}
    hit = {hits.bin for coverage in covered for hits in coverage.hits} - illegal
    impossible = {record.bin for record in declared.impossible} - hit
    bins = 1
    for coordinate in declared.coordinates:
        bins *= len(coordinate.bins)
    return len(hit), bins - len(impossible) - len(illegal)


def _plans(report: Report, agent: str) -> tuple[int, int]:
    covered = [suite.plans[agent] for suite in report.suites if agent in suite.plans]
    hit = {label for coverage in covered for label in coverage.covered}
    return len(hit), max((coverage.total for coverage in covered), default=0)


_MAX_LINES = 8
_STYLES: dict[PlanState, Style] = {
    "met": "ok",
    "waived": "warn",
    "open": "warn",
    "not checked": "warn",
    "failed": "bad",
}


class PlanView(View):
    """The view of the plan: the number of goals met, and what the others lack."""

    name = "verification_plan"

    def lines(self, report: Report, columns: int) -> Iterator[Line]:
        """The goals that are not met, at most some of them."""
        from pytest_hricdv.report.formatting import Line, plural

        if not PLAN.of(report):
            return
        whole, *parts = PLAN.of(report)
        yield Line(_headline(whole), _STYLES[whole.state])
        lacking = [part for part in parts if part.is_goal and part.state not in ("met", "waived")]
        for part in sorted(lacking, key=lambda part: part.state != "failed")[:_MAX_LINES]:
            yield Line(f"  {part.state}  {part.name}: {'; '.join(part.missing)}", _STYLES[part.state])
        if len(lacking) > _MAX_LINES:
            yield Line(f"  and {plural(len(lacking) - _MAX_LINES, 'more goal')}: see the report", "dim")

    def of_sheet(self, report: Report) -> SheetTable | None:
        """The goals, each with its owner, or that of its section."""
        if not PLAN.of(report):
            return None
        rows = [(part.title or part.name, owner, part.state, _describe_gap(part)) for part, owner in _owners(report)]
        return SheetTable("Plan", _headline(PLAN.of(report)[0]), ("Goal", "Owner", "State", "Missing"), tuple(rows))

    def section(self, report: Report) -> PageSection | None:
        """The plan as a table: each goal with its owner, or that of its section."""
        if not PLAN.of(report):
            return None
        rows = [{"goal": goal, "owner": owner, "style": _STYLES[goal.state]} for goal, owner in _owners(report)]
        values = {"whole": PLAN.of(report)[0], "rows": rows}
        headline = _headline(PLAN.of(report)[0])
        return PageSection(
            "plan", "Plan", "verification_plan/plan.html.jinja", values, place="requirements", headline=headline
        )


VIEW = PlanView()


def _owners(report: Report) -> Iterator[tuple[PlanItem, str]]:
    """The parts of the plan, each with who answers for it, or for its section."""
    owners = [""]
    for number, part in enumerate(PLAN.of(report)):
        owners = [*owners[: part.depth + 1], part.owner or owners[part.depth]]
        if number:  # the first is the plan itself
            yield part, owners[-1]


def _describe_gap(part: PlanItem) -> str:
    """What a goal lacks; of a section, how many of its goals are met."""
    from pytest_hricdv.report.formatting import plural

    return "; ".join(part.missing) if part.is_goal else f"section: {part.met} of {plural(part.goals, 'goal')} met"


def _headline(whole: PlanItem) -> str:
    from pytest_hricdv.report.formatting import plural

    return f"plan: {whole.met} of {plural(whole.goals, 'goal')} met ({whole.title})"
