"""The HTML page: one file that needs no network, made from the report alone."""

from collections.abc import Mapping
from hashlib import sha256
from typing import Any

import jinja2
from markupsafe import Markup

from pytest_hricdv.report import explanation, figure, plot, rerun, totals
from pytest_hricdv.report.line import visible

_OUTCOME_WORDS = {
    "passed": "passed",
    "failed": "failed",
    "known-violation": "known violation",
    "error": "error",
    "not-run": "not run",
}


def render(report: Mapping[str, Any]) -> str:
    """The page as text; the same report gives the same text.

    Args:
        report: a report that keeps the contract (`contract.faults` finds nothing).
    """
    return _environment().get_template("index.html.jinja").render(_context(report))


def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("pytest_hricdv", "report"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        finalize=_finalize,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters.update(
        percent=figure.percent,
        seconds=figure.seconds,
        quantity=figure.quantity,
        violation=explanation.violation,
        counts=explanation.counts,
        nearest_miss=explanation.nearest_miss,
        anchor=_anchor,
        times=totals.times,
        outcome=_OUTCOME_WORDS.__getitem__,
        naturally=lambda names: sorted(names, key=figure.natural),
    )
    return environment


def _finalize(value: object) -> object:
    """What jinja2 does to every value before it escapes it: nothing invisible gets onto the page."""
    return visible(value, keep="\n") if isinstance(value, str) and not isinstance(value, Markup) else value


def _context(report: Mapping[str, Any]) -> dict[str, Any]:
    plots = [plot.coverage_per_test(report), *plot.closure(report), plot.learning(report)]
    names = {name for test in report["tests"] for name in test["requirements"]}
    return {
        "report": report,
        "testbench": report.get("testbench") or "testbench",
        "requirements": report.get("requirements", {}),
        "code": report.get("code_under_test", {}),
        "merged": _merged(report),
        "outcomes": totals.outcomes(report),
        "loss": totals.loss(report),
        "time": totals.time(report),
        "suites": [(suite, totals.tallies(report, suite)) for suite in report["suites"]],
        "gaps": totals.gaps(report),
        "waivers": totals.waivers(report),
        "unmeasured": totals.unmeasured(report),
        "reachable": totals.percent_reachable,
        "share": figure.share,
        "plural": figure.plural,
        "plots": [(each, Markup(each.svg)) for each in plots if each is not None],
        "tested": sorted(names, key=figure.natural),
        "troubled": [test for test in report["tests"] if test["outcome"] in ("failed", "error", "not-run")],
        "command": lambda test: _command(report, test),
    }


def _command(report: Mapping[str, Any], test: Mapping[str, Any]) -> str:
    """The commands that run a test again, with the options of the run as far as the report has them."""
    seeds = {suite["name"]: suite["seed"] for suite in report["suites"]}
    again = report.get("rerun", {})
    seed, options, file = seeds.get(test["suite"], 0), again.get("options", ()), test.get("replay")
    return "\n".join(rerun.told(test, again.get("suite"), seed, options, file)[1:])


def _merged(report: Mapping[str, Any]) -> tuple[int, int]:
    """Statements covered by all suites together, and all statements."""
    files = report.get("code_under_test", {}).get("files", ())
    return sum(file["covered"] for file in files), sum(file["statements"] for file in files)


def _anchor(nodeid: str) -> str:
    """An id for links to a test: from the node id, which may hold characters that an id may not."""
    return "t-" + sha256(nodeid.encode("utf-8", "backslashreplace")).hexdigest()[:10]
