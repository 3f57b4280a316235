"""Closing a report: everything in it that follows from the rest, worked out from plain data.

A session's report and one merged from many are closed by the same function. So a merge is exact: it adds up tests, and
whatever is told of suites and of the whole is worked out anew.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from pytest_hricdv.cover import assertions, crossed, gaps
from pytest_hricdv.cover.closed import gains
from pytest_hricdv.cover.closure import TestCover, code_closure, curve, files, percent, plan_closure, union
from pytest_hricdv.cover.listing import bits_of, code_of
from pytest_hricdv.cover.points import Points
from pytest_hricdv.cover.source import Bits, CodeMap

SCHEMA = "hricdv-report/1"
Entry = dict[str, Any]


def close(report: Entry, unmeasured: str) -> Entry:
    """The report with all that follows from its declarations and its tests; what was there of it is replaced.

    Args:
        report: with what was declared (code, models, requirements, cross products, suites) and `tests`.
        unmeasured: why the code was not measured, for a report in which it was not.

    Raises:
        CoverError: a waived statement ran.
    """
    tests = sorted(report["tests"], key=_order)
    lost = [test["nodeid"] for test in tests if test["outcome"] == "not-run"]
    code = code_of(report["code_under_test"])
    total = union(map(cover_of, tests)) if code else None
    suites = [_suite(report, suite, code, tests) for suite in report["suites"]]
    return report | {
        "selected": len(tests),
        "reported": len(tests) - len(lost),
        "not_run": len(lost),
        "not_run_tests": sorted(lost),
        "code_under_test": report["code_under_test"] | _reached_code(code, total, unmeasured),
        "suites": suites,
        "closure": gains(_points(report, code), tests, runs_of) | {"gaps": _gaps(report, suites, code, total, tests)},
        "tests": tests,
    }


def _order(test: Entry) -> tuple[str, str, str]:
    return test["suite"], test["id"], test["nodeid"]


def cover_of(test: Entry) -> TestCover:
    """What a test covered, as bits again."""
    runs = runs_of(test)
    plans: dict[str, frozenset[str]] = {}
    for run in runs:
        for agent, labels in run["plans"].items():
            plans[agent] = plans.get(agent, frozenset()) | frozenset(labels)
    covers = [TestCover(test["id"], bits_of(run["code"]), plans, tuple(test["beliefs"])) for run in runs]
    return replace(covers[0], code=union(covers))


def runs_of(test: Entry) -> list[Entry]:
    """All runs of a test: one, but for a test of a merged report whose runs were not the same."""
    return [test, *test.get("repeats", ())]


def _reached_code(code: CodeMap | None, total: Bits | None, unmeasured: str) -> Entry:
    return {
        "measured": total is not None,
        "reason": unmeasured if total is None or total.branches is None else "",
        "files": files(code, total) if code else [],
    }


def _suite(report: Entry, suite: Entry, code: CodeMap | None, tests: Iterable[Entry]) -> Entry:
    mine = [test for test in tests if test["suite"] == suite["name"]]
    covers = [cover_of(test) for test in mine]
    declared = {agent: plans["declared"] for agent, plans in suite["plans"].items()}
    return suite | {
        "tests": len(mine),
        "fidelity": " and ".join(sorted({test["fidelity"] for test in mine} - {""})),
        "requirements": {name: assertions.tally(name, mine) for name in report["requirements"]},
        "code": code_closure(code, union(covers)) if code else {"statements": None, "branches": None},
        "plans": plan_closure(covers, declared),
        "cross": crossed.closure(report["cross_products"], [run for test in mine for run in runs_of(test)]),
        "curve": curve(covers),
        "closure": gains(_points(report, code), mine, runs_of),
    }


def _points(report: Entry, code: CodeMap | None) -> Points:
    illegal = {name: [each["bin"] for each in product["illegal"]] for name, product in report["cross_products"].items()}
    return Points(code.statements if code else 0, code.branches if code else 0, illegal)


def _gaps(
    report: Entry, suites: list[Entry], code: CodeMap | None, total: Bits | None, tests: list[Entry]
) -> list[Entry]:
    """What no test of any suite covers."""
    runs = [run for test in tests for run in runs_of(test)]
    products, explored = report["cross_products"], report.get("exploration", {})
    crossed_by_all = crossed.closure(products, runs)["products"]
    missing = {name: product["missing"] for name, product in crossed_by_all.items()}
    found = [
        *(gaps.code_gaps(code, total, runs) if code and total else ()),
        *gaps.plan_gaps(suites, runs, explored),
        *gaps.bin_gaps(products, missing, explored),
        *gaps.requirement_gaps(report["requirements"], tests),
    ]
    return [gap.plain() for gap in found]


def reached(report: Entry, kind: str) -> list[tuple[str, float | None]]:
    """Per suite, the percentage that a gate of this kind is held against; None where nothing was measured.

    Statements and branches: of what is reachable. Plans: of suites that a model made. Assertions: requirements that
    were checked. Cross: of what is possible.
    """
    suites = report["suites"]
    if kind == "plans":
        suites = [suite for suite in suites if suite["plans"]] or suites
    return [(suite["name"], _reached(suite, kind)) for suite in suites]


def _reached(suite: Entry, kind: str) -> float | None:
    if kind in ("statements", "branches"):
        closure = suite["code"][kind]
        return None if closure is None else float(closure["percent_reachable"])
    if kind == "plans":
        plans = suite["plans"].values()
        if not plans:
            return None
        return percent(sum(len(each["covered"]) for each in plans), sum(each["total"] for each in plans))
    if kind == "assertions":
        tallies = suite["requirements"].values()
        if not tallies:
            return None
        return percent(sum(tally["passed"] + tally["failed"] > 0 for tally in tallies), len(tallies))
    cross = suite["cross"]
    if not cross["bins"]:
        return None
    return percent(cross["hit"], crossed.possible(cross))
