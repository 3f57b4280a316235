"""The tables of docs/false-alarms.md."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from pytest_hricdv.report.formatting import by_requirement
from pytest_hricdv.results import proportion
from studies import page, session
from studies.false_alarms.alarms import RUN, SESSION, Alarm, Found


def context(found: Sequence[Found]) -> dict[str, Any]:
    """What the page's template is filled with."""
    alarms = [alarm for each in found for alarm in each.alarms]
    runs = sum(each.runs for each in found)
    alarmed = len({(alarm.where, alarm.seed) for alarm in alarms if alarm.oracle != SESSION})
    return {
        "runs": runs,
        "sessions": len(found),
        "seeds": sorted({each.seed for each in found}),
        "alarmed": alarmed,
        "share": proportion.share(alarmed, runs),
        "suites": suites(found),
        "requirements": requirements(found),
        "alarms": listed(alarms),
        "version": found[0].version,
        "code_sha256": found[0].code_sha256,
        "machine": session.machine(),
    }


def suites(found: Sequence[Found]) -> str:
    """A row for each suite."""
    rows = []
    for suite in dict.fromkeys(each.suite for each in found):
        of_suite = [each for each in found if each.suite == suite]
        runs = sum(each.runs for each in of_suite)
        rows.append([suite, len(of_suite), page.thousands(runs), sum(len(each.alarms) for each in of_suite)])
    return page.table(["suite", "seeds", "runs", "false alarms"], rows)


def requirements(found: Sequence[Found]) -> str:
    """A row for each requirement, and for what else can fail."""
    alarms = Counter(alarm.oracle for each in found for alarm in each.alarms)
    rows: list[list[object]] = []
    for name in sorted(found[0].titles, key=by_requirement):
        judged = [each.requirements[name] for each in found]
        sums = [sum(each.runs for each in judged), sum(each.attempts for each in judged)]
        known = sum(each.known for each in judged)
        margin, test = min(((each.margin, each.test) for each in judged if each.margin is not None), default=(None, ""))
        worst = "-" if margin is None else f"{margin:.3g} in {test}"
        rows.append([name, found[0].titles[name], *map(page.thousands, sums), known, alarms[name], worst])
    rows += [[name, "", "", "", "", alarms[name], ""] for name in (RUN, SESSION)]
    head = ["requirement", "", "runs that triggered it", "attempts", "known violations", "false alarms", "worst margin"]
    return page.table(head, rows)


def listed(alarms: Sequence[Alarm]) -> str:
    """A row for each alarm; empty where there is none."""
    rows = [[each.oracle, each.where, each.seed, each.text.replace("|", "\\|")] for each in alarms]
    return page.table(["what failed", "where", "seed", "how"], rows) if rows else ""
