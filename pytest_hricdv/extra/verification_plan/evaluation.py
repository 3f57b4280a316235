"""How far a verification plan is, by a report."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import takewhile

from msgspec.structs import replace

from pytest_hricdv.extra.verification_plan.records import STATES, PlanFeature, PlanState
from pytest_hricdv.results.derivation import code_covered
from pytest_hricdv.results.model import Report

Finding = tuple[PlanState, str]
"""What one wish of a goal came to, and what is missing for it."""


def evaluated(plan: Sequence[PlanFeature], report: Report) -> tuple[PlanFeature, ...]:
    """The plan with the state of each goal, and what it lacks.

    Args:
        plan: its parts, in the order of the file; earlier states in them have no effect.
        report: of a session, or merged.
    """
    done: list[PlanFeature] = []
    for part in reversed(plan):  # what a section has is known before it
        depth = part.depth
        inside = list(takewhile(lambda other, depth=depth: other.depth > depth, reversed(done)))  # type: ignore[misc]
        done.append(_goal(part, report) if part.is_goal else _section(part, inside))
    return tuple(reversed(done))


def _goal(goal: PlanFeature, report: Report) -> PlanFeature:
    findings = list(_findings(goal, report))
    state = max((state for state, _ in findings), key=STATES.index, default="open")
    missing = tuple(text for _, text in findings if text)
    return replace(goal, state=state, missing=missing, goals=1, met=int(state in ("met", "waived")))


def _section(section: PlanFeature, inside: Sequence[PlanFeature]) -> PlanFeature:
    goals = [part for part in inside if part.is_goal]
    state = max((part.state for part in goals), key=STATES.index, default="open")
    return replace(section, state=state, goals=len(goals), met=sum(goal.met for goal in goals))


def _findings(goal: PlanFeature, report: Report) -> Iterator[Finding]:
    for name in goal.requirements:
        yield _of_requirement(name, goal.triggers, report)
    for kind, wanted in (("statements", goal.statements), ("branches", goal.branches)):
        if wanted is not None:
            hit, total = code_covered(report, kind, goal.files)
            yield _of_share(kind, hit, total, wanted)
    for name, wanted in goal.cross.items():
        yield _of_share(name, *_cross(report, name), wanted)
    for agent, wanted in goal.plans.items():
        yield _of_share(f"plans of {agent}", *_plans(report, agent), wanted)


def _of_requirement(name: str, triggers: int, report: Report) -> Finding:
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
        if name in report.may_be_nc:
            return "waived", f"{name} need not be checked: {report.may_be_nc[name].reason}"
        return "not checked", f"{name} was not checked"
    if count < triggers:
        return "open", f"{name} was triggered {count} of {triggers} times"
    return "met", ""


def _of_share(name: str, hit: int, total: int, wanted: float) -> Finding:
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
