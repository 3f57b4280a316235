"""The tables of docs/studies/false-alarms.md."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from pytest_hricdv.report.formatting import by_requirement
from pytest_hricdv.results import proportion
from studies import page, session
from studies.false_alarms.alarms import RUN, SESSION, Alarm, Found


def context(sessions: Sequence[Found]) -> dict[str, Any]:
    """What the page's template is filled with."""
    alarms = [alarm for entry in sessions for alarm in entry.alarms]
    runs = sum(entry.runs for entry in sessions)
    alarmed = len({(alarm.where, alarm.seed) for alarm in alarms if alarm.oracle != SESSION})
    return {
        "runs": runs,
        "sessions": len(sessions),
        "seeds": sorted({entry.seed for entry in sessions}),
        "alarmed": alarmed,
        "share": proportion.share(alarmed, runs),
        "suites": suites(sessions),
        "requirements": requirements(sessions),
        "alarms": listed(alarms),
        "version": sessions[0].version,
        "code_sha256": sessions[0].code_sha256,
        "machine": session.machine(),
    }


def suites(sessions: Sequence[Found]) -> str:
    """A row for each suite."""
    rows = []
    for suite in dict.fromkeys(entry.suite for entry in sessions):
        of_suite = [entry for entry in sessions if entry.suite == suite]
        runs = sum(entry.runs for entry in of_suite)
        rows.append([suite, len(of_suite), page.thousands(runs), sum(len(entry.alarms) for entry in of_suite)])
    return page.table(["suite", "seeds", "runs", "false alarms"], rows)


def requirements(sessions: Sequence[Found]) -> str:
    """A row for each requirement, and for what else can fail."""
    alarms = Counter(alarm.oracle for entry in sessions for alarm in entry.alarms)
    rows: list[list[object]] = []
    for name in sorted(sessions[0].titles, key=by_requirement):
        judged = [entry.requirements[name] for entry in sessions]
        sums = [sum(result.runs for result in judged), sum(result.triggers for result in judged)]
        violating = sum(result.known_violations for result in judged)
        margin, test = min(
            ((result.margin, result.test) for result in judged if result.margin is not None), default=(None, "")
        )
        worst = "-" if margin is None else f"{margin:.3g} in {test}"
        rows.append([name, *map(page.thousands, sums), violating, alarms[name], worst])
    rows += [[name, "", "", "", alarms[name], ""] for name in (RUN, SESSION)]
    head = ["requirement", "runs that triggered it", "triggers", "known violations", "false alarms", "worst margin"]
    return page.table(head, rows)


def listed(alarms: Sequence[Alarm]) -> str:
    """A row for each alarm; empty where there is none."""
    rows = [[alarm.oracle, alarm.where, alarm.seed, alarm.text.replace("|", "\\|")] for alarm in alarms]
    return page.table(["what failed", "where", "seed", "how"], rows) if rows else ""
