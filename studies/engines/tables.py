"""The tables of docs/engines.md."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

from pytest_hricdv.extra.engines.agreement import Agreement
from pytest_hricdv.report.formatting import natural
from studies import page, session

PAPER = ("R1", "R2", "R3", "R4")
"""The requirements of the published case study that have a column of their own."""


def context(found: Mapping[str, Agreement]) -> dict[str, Any]:
    """What the template needs.

    Args:
        found: session -> how far the engines agree in it.
    """
    return {
        "engines": " and ".join(next(iter(found.values())).engines),
        "suites": _suites(found),
        "requirements": _requirements(found),
        "differences": [
            f"{name}, {test}: {text}"
            for name, each in found.items()
            for test in sorted(each.differing, key=natural)
            for text in each.differing[test]
        ],
        "machine": session.machine(),
    }


def _suites(found: Mapping[str, Agreement]) -> str:
    rows = []
    for name, each in found.items():
        others = [verdicts for requirement, verdicts in each.verdicts.items() if requirement not in PAPER]
        rest = _share(sum(one.same for one in others), sum(one.tests for one in others))
        paper = [_share(each.verdicts[one].same, each.verdicts[one].tests) for one in PAPER]
        rows.append([name, each.tests, _share(each.same, each.interactions), *paper, rest, len(each.differing)])
    head = ["session", "tests", "legs that end alike", *PAPER, "other requirements", "tests that depend on the engine"]
    return page.table(head, rows)


def _requirements(found: Mapping[str, Agreement]) -> str:
    totals: Counter[tuple[str, str]] = Counter()
    margins: dict[str, float] = {}
    for each in found.values():
        for name, verdicts in each.verdicts.items():
            for what in ("tests", "same", "triggers"):
                totals[name, what] += getattr(verdicts, what)
            if verdicts.margin is not None:
                margins[name] = max(verdicts.margin, margins.get(name, 0.0))
    rows = [
        [
            name,
            _share(totals[name, "same"], totals[name, "tests"]),
            _share(totals[name, "triggers"], totals[name, "tests"]),
            f"{margins[name]:.3g}" if name in margins else "-",
        ]
        for name in sorted({name for name, _ in totals}, key=natural)
    ]
    return page.table(["requirement", "same verdict", "same number of triggers", "margins differ by at most"], rows)


def _share(part: int, whole: int) -> str:
    return f"{page.percent(100.0 * part / whole)} of {page.thousands(whole)}" if whole else "-"
