"""Closure: what a suite covered together, of what is reachable, and what is missing."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any

from pytest_hricdv.cover.source import Bits, CodeMap, CoverError


@dataclass(frozen=True)
class TestCover:
    """What one test covered: code bits (None: unmeasured), plans (agent -> labels); and the beliefs it came from."""

    __test__ = False

    id: str
    code: Bits | None
    plans: Mapping[str, frozenset[str]]
    beliefs: tuple[str, ...] = ()


def union(tests: Iterable[TestCover]) -> Bits | None:
    """All measured bits together, whatever the order; None when nothing was measured."""
    measured = [test.code for test in tests if test.code is not None]
    return reduce(lambda a, b: a | b, measured) if measured else None


def code_closure(code: CodeMap, bits: Bits | None) -> dict[str, dict[str, Any] | None]:
    """Raw and reachable coverage of statements and branches; None for what was not measured.

    Reachable is everything but the waived, never what tests happened to reach.

    Raises:
        CoverError: a waived statement ran: the waiver is wrong and must go.
    """
    if bits is None:
        return {"statements": None, "branches": None}
    waived = code.waived()
    refuse_broken_waivers(code, bits)
    assert waived.branches is not None
    branches = None
    if bits.branches is not None:
        branches = _ratio(bits.branches, code.branches, waived.branches)
    return {"statements": _ratio(bits.statements, code.statements, waived.statements), "branches": branches}


def refuse_broken_waivers(code: CodeMap, bits: Bits) -> None:
    """Raises CoverError when a statement ran that carries `# unreachable`."""
    uncovered = {(file.name, line) for file, lines, _ in code.uncovered(bits) for line in lines}
    for waiver in code.waivers:
        if (waiver.file, waiver.line) not in uncovered:
            raise CoverError(
                f"{waiver.file}:{waiver.line}: ran, though it is waived as unreachable ({waiver.reason}): "
                "remove the waiver"
            )


def _ratio(bits: int, total: int, waived: int) -> dict[str, Any]:
    covered, reachable = bits.bit_count(), total - waived.bit_count()
    return {
        "covered": covered,
        "total": total,
        "reachable": reachable,
        "percent": percent(covered, total),
        "percent_reachable": percent((bits & ~waived).bit_count(), reachable),
    }


def percent(part: int, whole: int) -> float:
    """100 % of nothing is 100 %."""
    return round(100.0 * part / whole, 2) if whole else 100.0


def plan_closure(tests: Sequence[TestCover], labels: Mapping[str, Sequence[str]]) -> dict[str, dict[str, Any]]:
    """Per agent: the plans that the tests' beliefs triggered, in source order, and those that none did.

    `reached` says of each plan how many tests and belief sets reach it, the smallest of these, and a test that has it.
    """
    closure = {}
    for agent, plans in labels.items():
        reached = {plan: _reached([t for t in tests if plan in t.plans.get(agent, ())]) for plan in plans}
        closure[agent] = {
            "covered": [plan for plan in plans if reached[plan]["tests"]],
            "missing": [plan for plan in plans if not reached[plan]["tests"]],
            "total": len(plans),
            "declared": list(plans),
            "reached": {plan: each for plan, each in reached.items() if each["tests"]},
        }
    return closure


def _reached(tests: Sequence[TestCover]) -> dict[str, Any]:
    sets = {test.beliefs for test in tests if test.beliefs}
    first = min(tests, key=lambda test: (len(test.beliefs) or math.inf, test.beliefs, test.id), default=None)
    return {
        "tests": len(tests),
        "belief_sets": len(sets),
        "shortest": list(first.beliefs) if first else [],
        "test": first.id if first else "",
    }


def curve(tests: Iterable[TestCover]) -> list[dict[str, int]]:
    """Cumulative coverage after 1, 2, ... tests in the order of their ids (so that no scheduling shows in it)."""
    points = []
    code: Bits | None = None
    plans: set[tuple[str, str]] = set()
    for number, test in enumerate(sorted(tests, key=lambda test: test.id), 1):
        if test.code is not None:
            code = test.code if code is None else code | test.code
        plans |= {(agent, plan) for agent, labels in test.plans.items() for plan in labels}
        statements = code.statements.bit_count() if code else 0
        branches = (code.branches or 0).bit_count() if code else 0
        points.append({"tests": number, "statements": statements, "branches": branches, "plans": len(plans)})
    return points


def files(code: CodeMap, bits: Bits | None) -> list[dict[str, Any]]:
    """Per file of the code under test: statements, covered, and what is missing; empty when unmeasured."""
    if bits is None:
        return []
    return [
        {
            "file": file.name,
            "statements": len(file.statements),
            "covered": len(file.statements) - len(lines),
            "missing_lines": list(lines),
            "missing_branches": [list(arc) for arc in arcs],
        }
        for file, lines, arcs in code.uncovered(bits)
    ]


__all__ = ["CoverError", "TestCover", "code_closure", "curve", "files", "percent", "plan_closure", "union"]
