"""The tests on the page: an index with a short row for each, and the packed details of each.

`html` puts `index` and `packs` into the page. The browser makes its tables, plots and searches from the index, and
unpacks the details of a test when the test's page is opened.
"""

import base64
from collections.abc import Iterator, Mapping, Sequence
from hashlib import sha256
from typing import Any
from zlib import compress  # as it is now: the code under test may replace it for the whole process

from msgspec import to_builtins

from pytest_hricdv._base import own_json as json
from pytest_hricdv.monitor import RequirementResult
from pytest_hricdv.report import behaviour_view, explanation
from pytest_hricdv.report.formatting import by_requirement, capitalize, natural, quantity, seconds
from pytest_hricdv.report.view import failure_causes, views
from pytest_hricdv.report.violations import margin_text, margin_unit, violation_line
from pytest_hricdv.results.model import ReplayComparison, Report, TestResult

TESTS_PER_PACK = 20
"""Tests whose details are compressed together, and unpacked at once: the details of 134 tests take 611 kB in packs of
5 tests, 567 kB with 20, and 557 kB with 50, but a test opens more slowly in a larger pack."""
MAX_LISTED = 20
"""Most violations of a requirement that the page of a test lists (chosen: a screen); each event may add one."""

FOLDER = "details"
"""The folder next to the page that holds the packs of a large report."""

_LETTERS = {"Passed": "P", "Failed": "F", "NC": "N"}
PlanName = tuple[str, str]
"""Agent and label."""


def index(report: Report) -> dict[str, Any]:
    """The rows, and the names that they refer to by number, as plain data.

    Returns:
        `requirements`, `suites`, `plans` ([agent, label] each), `actions` (lines of abstract tests): names. `rows`: a
        list per test, in the order of the report's tests; `data.js` says what stands at which position.
    """
    requirements = requirement_names(report)
    suites = [suite.name for suite in report.suites]
    suites += sorted({test.suite for test in report.tests} - set(suites))
    plans = plan_names(report)
    numbers = {plan: number for number, plan in enumerate(plans)}
    actions = {line: number for number, line in enumerate(dict.fromkeys(_all_lines(report)))}
    rows = [
        [
            *_row(report, test, requirements, suites.index(test.suite), numbers),
            sorted({actions[line] for line in test.abstract}),
        ]
        for test in report.tests
    ]
    return {"requirements": requirements, "suites": suites, "plans": plans, "actions": [*actions], "rows": rows}


def index_causes(report: Report) -> list[dict[str, Any]]:
    """The causes, where somebody looked for them; `tests` are numbers in the order of the report."""
    numbers = {test.nodeid: number for number, test in enumerate(report.tests)}
    causes = failure_causes(report)
    return [
        {
            "title": cause.title,
            "anchor": cause.anchor,
            "decides": cause.decides,
            "lines": [line.text.strip() for line in cause.lines[1:]],
            "tests": sorted(numbers[name] for name in cause.tests if name in numbers),
        }
        for cause in (causes.causes if causes else ())
    ]


def _all_lines(report: Report) -> Iterator[str]:
    for test in report.tests:
        yield from test.abstract


def requirement_names(report: Report) -> list[str]:
    """Every requirement that a test or the report names, R2 before R10."""
    names = {name for test in report.tests for name in test.requirements}
    return sorted(names | set(report.requirements), key=by_requirement)


def plan_names(report: Report) -> list[PlanName]:
    """All coverage plans of all suites."""
    names: dict[PlanName, None] = {}
    for suite in report.suites:
        for agent in sorted(suite.plans):
            labels = sorted({*suite.plans[agent].covered, *suite.plans[agent].missing}, key=natural)
            names.update(dict.fromkeys((agent, label) for label in labels))
    return list(names)


def plan_bits(test: TestResult, numbers: Mapping[PlanName, int]) -> int:
    """The coverage plans that a test's beliefs triggered, as a bit set."""
    plans = {(agent, label) for agent, labels in test.plans.items() for label in labels}
    return sum(1 << numbers[plan] for plan in plans if plan in numbers)


def anchor(nodeid: str) -> str:
    """A test's name in links: a digest of the node id, which may hold characters that an address may not."""
    return sha256(nodeid.encode("utf-8", "backslashreplace")).hexdigest()[:10]


def packs(report: Report) -> Iterator[str]:
    """The details of the tests in chunks, each a line of base64 of deflated JSON, in the order of the tests."""
    for start in range(0, len(report.tests), TESTS_PER_PACK):
        part = (details(report, test) for test in report.tests[start : start + TESTS_PER_PACK])
        text = "\n".join(json.dumps(found, separators=(",", ":"), sort_keys=True) for found in part)
        yield base64.b64encode(compress(text.encode("ascii"))).decode("ascii")


def pack_name(number: int) -> str:
    """The file of a pack, relative to the page."""
    return f"{FOLDER}/{number:04d}.js"


def details(report: Report, test: TestResult) -> dict[str, Any]:
    """One test as plain data for the page's scripts, every figure as text."""
    return {
        "nodeid": test.nodeid,
        "beliefs": test.beliefs,
        "plans": {agent: sorted(labels, key=natural) for agent, labels in test.plans.items()},
        "aim": test.name or test.target,
        "abstract": test.abstract,
        "acted": _action_times(test),
        "seen": test.bystander_events,
        "actions": [(action.command, _values(action.parameters)) for action in test.concrete.actions],
        "run": _values(test.concrete.run),
        "verdicts": [
            _verdict(report, name, test.requirements[name]) for name in sorted(test.requirements, key=by_requirement)
        ],
        "failure": test.failure,
        "faults": test.errors,
        "rerun": [line.strip() for line in explanation.instructions_of(report, test)[1:]],
        "facts": {name: value for name, value in _facts(test).items() if value},
        "repeats": len(test.repeats),
        "replayed": _replay_text(test.replayed) if test.replayed else "",
        "timeline": to_builtins(test.timeline),
        "changed": behaviour_view.details(report, test),
        **{key: value for view in views() for key, value in view.of_test(report, test).items()},
    }


def _action_times(test: TestResult) -> list[float | None]:
    """When each action began (s); None for one that did not, and nothing for those after the last that did."""
    times = {number: round(time_s, 3) for time_s, number in test.action_starts}
    return [times.get(number) for number in range(max(times, default=-1) + 1)]


def _row(
    report: Report, test: TestResult, requirements: Sequence[str], suite: int, plans: Mapping[PlanName, int]
) -> list[Any]:
    """A row that `data.js` reads by position."""
    results = [test.requirements.get(name) for name in requirements]
    return [
        anchor(test.nodeid),
        test.id,
        suite,
        test.outcome,
        "".join(_letter(report, name, test) for name in requirements),
        [result.triggers if result else 0 for result in results],
        [_round(result.margin) if result else None for result in results],
        test.outcomes,
        _round(test.code.percent) if test.code else None,
        _round(test.sim_s),
        " ".join(test.beliefs),
        f"{int(test.code.bits[0], 16) if test.code else 0:x}",
        f"{plan_bits(test, plans):x}",
    ]


def _letter(report: Report, name: str, test: TestResult) -> str:
    """K for a violation that is known, the verdict's first letter otherwise."""
    result = test.requirements.get(name)
    if result is None:
        return "-"
    is_known = name in report.known_violations and not report.strict and not result.outside
    return "K" if result.verdict == "Failed" and is_known else _LETTERS[result.verdict]


def _round(value: float | None) -> float | None:
    """Five digits are more than any table or plot shows."""
    return None if value is None else float(f"{value:.5g}")


def _facts(test: TestResult) -> dict[str, str]:
    return {
        "Ended": test.end_reason,
        "Simulated": seconds(test.sim_s),
        "Without physics": seconds(test.skipped_s),
        "Simulation": test.fidelity,
        "Physics engine": " and ".join(test.engines),
        "Wall clock": seconds(test.wall_s),
        "Own seed": str(test.seed),
        "Record SHA-256": test.record_sha256 or "",
        "Code": test.unmeasured and f"unmeasured: {test.unmeasured}",
        **{name: text for view in views() for name, text in view.facts(test).items()},
    }


def _values(values: Mapping[str, object]) -> str:
    return ", ".join(f"{name} {quantity(values[name])}" for name in sorted(values))


def _verdict(report: Report, name: str, result: RequirementResult) -> dict[str, Any]:
    at_s, unit = result.margin_time_s, margin_unit(report, name)
    at = f" at {seconds(at_s)}" if isinstance(at_s, int | float) else ""
    return {
        "name": name,
        "verdict": result.verdict,
        "counts": explanation.counts(result),
        "margin": "" if result.margin is None else margin_text(result.margin, unit) + at,
        "miss": explanation.near_miss(result.near_miss) if result.near_miss else "",
        "violations": [
            violation_line(violation, report.units or {}, unit) for violation in result.violations[:MAX_LISTED]
        ],
        "more": max(0, len(result.violations) - MAX_LISTED),
        "times": [violation.time_s for violation in result.violations],
    }


def _replay_text(replayed: ReplayComparison) -> str:
    text, hint = explanation.describe_replay(replayed)
    return f"Replay of {replayed.file}: {text}.{f' {capitalize(hint)}.' if hint else ''}"
