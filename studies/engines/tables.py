"""The tables of docs/studies/engines.md."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

from pytest_hricdv.extra.engines.view import Agreement
from pytest_hricdv.report.formatting import natural
from studies import page, session

PAPER = ("R1", "R2", "R3", "R4")
"""The requirements of the published case study that have a column of their own."""


def context(by_session: Mapping[str, Agreement]) -> dict[str, Any]:
    """What the template needs.

    Args:
        by_session: session -> how far the engines agree in it.
    """
    return {
        "engines": " and ".join(next(iter(by_session.values())).engines),
        "suites": _suites(by_session),
        "requirements": _requirements(by_session),
        "differences": [
            f"{name}, {test}: {text}"
            for name, agreed in by_session.items()
            for test in sorted(agreed.differing, key=natural)
            for text in agreed.differing[test]
        ],
        "machine": session.machine(),
    }


def _suites(by_session: Mapping[str, Agreement]) -> str:
    rows = []
    for name, agreed in by_session.items():
        others = [verdicts for requirement, verdicts in agreed.verdicts.items() if requirement not in PAPER]
        rest = _share(sum(verdicts.same for verdicts in others), sum(verdicts.tests for verdicts in others))
        paper = [_share(agreed.verdicts[requirement].same, agreed.verdicts[requirement].tests) for requirement in PAPER]
        rows.append([name, agreed.tests, _share(agreed.same, agreed.interactions), *paper, rest, len(agreed.differing)])
    head = ["session", "tests", "legs that end alike", *PAPER, "other requirements", "tests that depend on the engine"]
    return page.table(head, rows)


def _requirements(by_session: Mapping[str, Agreement]) -> str:
    totals: Counter[tuple[str, str]] = Counter()
    margins: dict[str, float] = {}
    for agreed in by_session.values():
        for name, verdicts in agreed.verdicts.items():
            for kind in ("tests", "same", "triggers"):
                totals[name, kind] += getattr(verdicts, kind)
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
        if margins.get(name) or min(totals[name, "same"], totals[name, "triggers"]) < totals[name, "tests"]
    ]
    return page.table(["requirement", "same verdict", "same number of triggers", "margins differ by at most"], rows)


def _share(part: int, whole: int) -> str:
    return f"{page.percent(100.0 * part / whole)} of {page.thousands(whole)}" if whole else "-"
