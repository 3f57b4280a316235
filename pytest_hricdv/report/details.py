"""What the page shows of each single test, packed: the browser unpacks it when the test's page is opened."""

import base64
import json
import zlib
from collections.abc import Iterator, Mapping
from typing import Any

from msgspec import to_builtins

from pytest_hricdv.coverage.records import RequirementResult
from pytest_hricdv.report import explanation
from pytest_hricdv.report.formatting import natural, quantity, seconds
from pytest_hricdv.report.rerun import instructions_of, replay_command
from pytest_hricdv.results.model import ReplayComparison, Report, ShrunkTest, TestResult

TESTS_PER_PACK = 50
FOLDER = "details"
"""The folder beside the page that holds the packs of a large report."""


def packs(report: Report) -> Iterator[str]:
    """The details of every so many tests as base64 of deflated JSON: a list of objects, in the order of the tests."""
    for start in range(0, len(report.tests), TESTS_PER_PACK):
        part = [details(report, test) for test in report.tests[start : start + TESTS_PER_PACK]]
        text = json.dumps(part, separators=(",", ":"), sort_keys=True)
        yield base64.b64encode(zlib.compress(text.encode("ascii"))).decode("ascii")


def pack_name(number: int) -> str:
    """The file of a pack, relative to the page."""
    return f"{FOLDER}/{number:04d}.js"


def details(report: Report, test: TestResult) -> dict[str, Any]:
    """One test as plain data for the page's scripts, every figure as text."""
    return {
        "nodeid": test.nodeid,
        "beliefs": test.beliefs,
        "plans": {agent: sorted(labels, key=natural) for agent, labels in test.plans.items()},
        "aim": test.name or test.aim,
        "abstract": test.abstract,
        "acted": [round(time_s, 3) for time_s in test.acted_s or ()],
        "actions": [(action.command, _values(action.parameters)) for action in test.concrete.actions],
        "run": _values(test.concrete.run),
        "verdicts": [
            _verdict(name, test.requirements[name], report.units or {})
            for name in sorted(test.requirements, key=natural)
        ],
        "failure": test.failure,
        "rerun": [line.strip() for line in instructions_of(report, test)[1:]],
        "facts": {name: value for name, value in _facts(test).items() if value},
        "film": to_builtins(test.film),
        "shrunk": [_shrunk(name, each, report) for name, each in sorted(test.shrunk.items())],
        "repeats": len(test.repeats),
        "replayed": _replayed(test.replayed) if test.replayed else "",
        "timeline": to_builtins(test.timeline),
    }


def _facts(test: TestResult) -> dict[str, str]:
    return {
        "Ended": test.ended,
        "Simulated": seconds(test.sim_s),
        "Without physics": seconds(test.skipped_s),
        "Simulation": test.fidelity,
        "Wall clock": seconds(test.wall_s),
        "Own seed": str(test.seed),
        "Record SHA-256": test.record_sha256 or "",
        "Code": test.unmeasured and f"unmeasured: {test.unmeasured}",
    }


def _values(values: Mapping[str, object]) -> str:
    return ", ".join(f"{name} {quantity(values[name])}" for name in sorted(values))


def _verdict(name: str, result: RequirementResult, units: Mapping[str, str]) -> dict[str, Any]:
    at_s = result.margin_time_s
    at = f" at {seconds(at_s)}" if isinstance(at_s, int | float) else ""
    return {
        "name": name,
        "verdict": result.verdict,
        "counts": explanation.counts(result),
        "margin": "" if result.margin is None else quantity(result.margin) + at,
        "miss": explanation.nearest_miss(result.nearest_miss) if result.nearest_miss else "",
        "violations": [explanation.violation(each, units) for each in result.violations],
        "times": [each.time_s for each in result.violations if each.time_s is not None],
    }


def _shrunk(requirement: str, shrunk: ShrunkTest, report: Report) -> dict[str, Any]:
    return {
        "requirement": requirement,
        "from": shrunk.actions_before,
        "abstract": shrunk.abstract,
        "note": shrunk.note,
        "rerun": replay_command(shrunk.replay, report.rerun.options) if shrunk.replay else "",
    }


def _replayed(replayed: ReplayComparison) -> str:
    if replayed.same:
        return f"Replay of {replayed.file}: the same run, to the bit."
    if replayed.changed:
        return f"Replay of {replayed.file}: the run differs from the recording; changed: {', '.join(replayed.changed)}."
    return f"Replay of {replayed.file}: the run differs from the recording; cause unknown."
