"""Short answers about a report, as plain data: failures and causes, gaps, and single items.

`ask` calls the function for a question; `hricdv report query` and the server (`hricdv report mcp`) use it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import msgspec

from pytest_hricdv.report.explanation import instructions_of, replay_command
from pytest_hricdv.report.formatting import natural
from pytest_hricdv.report.totals import has_failed
from pytest_hricdv.results.codec import ReportError
from pytest_hricdv.results.derivation import percentages
from pytest_hricdv.results.model import Report

Answer = dict[str, Any]

MAX_ITEMS = 50
"""Maximum number of entries of a list in an answer; `total` counts all of them."""


def status(report: Report) -> Answer:
    """Whether the session failed, with its tests by outcome, verdicts of each requirement, and percentages covered."""
    verdicts = {
        name: {
            "passed": sum(suite.requirements[name].passed for suite in report.suites if name in suite.requirements),
            "failed": sum(suite.requirements[name].failed for suite in report.suites if name in suite.requirements),
            "not_checked": sum(suite.requirements[name].nc for suite in report.suites if name in suite.requirements),
        }
        for name in sorted(report.requirements, key=natural)
    }
    gates = report.gates.failed if report.gates is not None else ()
    return {
        "testbench": report.testbench,
        "failed": has_failed(report) or bool(gates or report.problems),
        "tests": dict(sorted(Counter(test.outcome for test in report.tests).items())),
        "not_run": report.not_run,
        "failed_gates": [*gates],
        "problems": [*report.problems],
        "requirements": verdicts,
        "percent": {kind: dict(percentages(report, kind)) for kind in ("statements", "branches", "plans")},
        "open_points": sum(len(gap.items) for gap in report.closure.gaps or ()),
        "revision": "" if report.origin is None else report.origin.revision,
    }


def causes(report: Report) -> Answer:
    """The causes of failures, the most frequent first: likely places, the deciding change, and the shortest test."""
    found = [msgspec.to_builtins(cause) for cause in getattr(report, "causes", ())]
    return _list(_cause(cause, report) for cause in found)


def _cause(cause: Mapping[str, Any], report: Report) -> Answer:
    replay = cause.get("replay")
    return {
        "id": cause["id"],
        "requirements": cause["requirements"],
        "known": cause.get("is_known", False),
        "tests": cause["tests"],
        "likely_places": [
            {"file": place["file"], "line": place["line"]}
            for place in cause.get("locations", ())
            if place.get("likely")
        ],
        "code_was_at": cause.get("stood", []),
        "passes": cause.get("deciding_change", ""),
        "shortest_test": cause.get("minimal", []),
        "again": replay_command(replay, report.rerun_options.options) if replay else "",
    }


def open_points(report: Report, kind: str = "") -> Answer:
    """What no test covers, why, and what is likely to cover it; code comes first."""
    gaps = [gap for gap in report.closure.gaps or () if kind in ("", gap.kind)]
    return _list(msgspec.to_builtins(gap) for gap in gaps)


def test(report: Report, name: str) -> Answer:
    """A test by its id or node id: its actions with start times, verdicts and violations, and how to run it again."""
    result = _find("test", name, {key: test for test in report.tests for key in (test.id, test.nodeid)})
    return {
        "id": result.id,
        "nodeid": result.nodeid,
        "outcome": result.outcome,
        "target": result.target,
        "beliefs": [*result.beliefs],
        "actions": [
            {"line": line, **parameters}
            for line, parameters in zip(result.abstract, msgspec.to_builtins(result.concrete.actions), strict=False)
        ],
        "began_s": [[time_s, number + 1] for time_s, number in result.action_starts],
        "ended": result.end_reason,
        "failure": result.failure,
        "errors": [*result.errors],
        "verdicts": {key: verdict.verdict for key, verdict in result.requirements.items()},
        "violations": {
            key: msgspec.to_builtins(verdict.violations[:5])
            for key, verdict in result.requirements.items()
            if verdict.violations
        },
        "replay": result.replay or "",
        "again": instructions_of(report, result)[-1].strip(),
    }


def requirement(report: Report, name: str) -> Answer:
    """A requirement: formula, source, verdicts, least margin, and near misses of its antecedent."""
    text = _find("requirement", name, report.requirements)
    results = [(test.id, test.requirements[name]) for test in report.tests if name in test.requirements]
    margins = [(verdict.margin, key) for key, verdict in results if verdict.margin is not None]
    return {
        "id": name,
        **msgspec.to_builtins(text),
        "verdicts": dict(Counter(verdict.verdict for _, verdict in results)),
        "triggers": sum(verdict.triggers for _, verdict in results),
        "least_margin": dict(zip(("margin", "test"), min(margins), strict=True)) if margins else None,
        "failed_tests": [key for key, verdict in results if verdict.verdict == "Failed"][:MAX_ITEMS],
        "near_misses": [
            {"test": key, **msgspec.to_builtins(verdict.near_miss)} for key, verdict in results if verdict.near_miss
        ][:5],
        "known_violation": report.known_violations.get(name, ""),
    }


def coverage(report: Report, name: str) -> Answer:
    """The coverage of a file of the code under test by all tests."""
    return dict(msgspec.to_builtins(_find("file", name, {file.file: file for file in report.code_under_test.files})))


def changes(report: Report) -> Answer:
    """Changes of behaviour since the baseline that the session was compared with."""
    if report.changes is None:
        raise ReportError("the session was not compared: run it with --hri-baseline=FILE")
    return dict(msgspec.to_builtins(report.changes))


OF_A_REPORT: Mapping[str, Callable[[Report], Answer]] = {
    "status": status,
    "causes": causes,
    "open": open_points,
    "changes": changes,
}
OF_A_NAME: Mapping[str, Callable[[Report, str], Answer]] = {
    "test": test,
    "requirement": requirement,
    "coverage": coverage,
}
"""Questions about a report, and about an item of it by its name."""


def ask(report: Report, what: str, name: str = "") -> Answer:
    """The answer to a question.

    Raises:
        ReportError: there is no such question, or no item with that name.
    """
    if what in OF_A_REPORT and not name:
        return OF_A_REPORT[what](report)
    if what in OF_A_NAME and name:
        return OF_A_NAME[what](report, name)
    if what in OF_A_NAME:
        raise ReportError(f"{what}: expected a name, as in `{what} NAME`")
    raise ReportError(f"no such question: {what}{f' {name}' * bool(name)}; expected {', '.join(_questions())}")


def _questions() -> list[str]:
    return [*OF_A_REPORT, *(f"{what} NAME" for what in OF_A_NAME)]


def _find(kind: str, name: str, found: Mapping[str, Any]) -> Any:
    if name not in found:
        some: Sequence[str] = sorted(found, key=natural)[:10]
        raise ReportError(f"no {kind} {name!r} in the report, which has {', '.join(some) or 'none'}")
    return found[name]


def _list(entries: Iterable[Answer]) -> Answer:
    every = [*entries]
    return {"total": len(every), "items": every[:MAX_ITEMS]}
