"""The HTML report: a page that needs no network, made from the report alone; of a large campaign, files beside it."""

import json
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files
from typing import Any
from urllib.parse import quote

import jinja2
from markupsafe import Markup

from pytest_hricdv.report import closure, curves, details, explanation, figure, judged, rerun, rows, texts, totals
from pytest_hricdv.report.files import DETAILS, PAGE_NAME
from pytest_hricdv.report.line import visible

EMBEDDED_BYTES = 1_200_000
"""Tests' details of more than this lie in files beside the page: it is to be opened in no time."""

_SCRIPTS = (
    "element",
    "data",
    "table",
    "plots",
    "tests",
    "requirement",
    "suites",
    "closure",
    "cross",
    "timeline",
    "test",
    "main",
)
_STYLES = ("theme", "layout", "parts", "views")
_OUTCOME_WORDS = {
    "passed": "passed",
    "failed": "failed",
    "known-violation": "known violation",
    "error": "error",
    "not-run": "not run",
}


def pages(report: Mapping[str, Any]) -> dict[str, str]:
    """The files of the report for people, by name, the page itself last; the same report gives the same text.

    Args:
        report: a report that keeps the contract (`contract.faults` finds nothing).
    """
    packs = list(details.packs(report))
    embedded = sum(map(len, packs)) <= EMBEDDED_BYTES
    beside = {} if embedded else {pack_name(n): f'hricdvPack({n},"{pack}")\n' for n, pack in enumerate(packs)}
    context = _context(report) | {"packs": packs if embedded else []}
    return {
        **beside,
        PAGE_NAME: _environment(report.get("rerun", {}).get("options", ()))
        .get_template("index.html.jinja")
        .render(context),
    }


def pack_name(number: int) -> str:
    """The file of a pack of tests' details, relative to the page."""
    return f"{DETAILS}/{number:04d}.js"


def _environment(options: Sequence[str]) -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("pytest_hricdv", "report/page"),
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
        anchor=rows.anchor,
        address=_address,
        times=totals.times,
        replayed=lambda file: rerun.replay(file, options),
        outcome=_OUTCOME_WORDS.__getitem__,
    )
    return environment


def _finalize(value: object) -> object:
    """What jinja2 does to every value before it escapes it: nothing invisible gets onto the page."""
    return visible(value, keep="\n\t") if isinstance(value, str) and not isinstance(value, Markup) else value


def _address(name: str) -> str:
    """A name as a part of a link within the page."""
    return quote(name.encode("utf-8", "backslashreplace"), safe="")


def _context(report: Mapping[str, Any]) -> dict[str, Any]:
    names = rows.requirement_names(report)
    return {
        "report": report,
        "testbench": report.get("testbench") or "testbench",
        "code": report.get("code_under_test", {}),
        "merged": _merged(report),
        "outcomes": totals.outcomes(report),
        "gates": report.get("gates", {}),
        "loss": totals.loss(report),
        "time": totals.time(report),
        "suites": [(suite, totals.tallies(report, suite)) for suite in report["suites"]],
        "holes": closure.holes(report),
        "shown_items": closure.SHOWN_ITEMS,
        "waivers": totals.waivers(report),
        "unmeasured": totals.unmeasured(report),
        "reachable": totals.percent_reachable,
        "plans_covered": totals.plans_covered,
        "bins_covered": totals.bins_covered,
        "share": figure.share,
        "plural": figure.plural,
        "requirements": [judged.requirement(report, name) for name in names],
        "texts": {"code": texts.code(report), "plans": texts.models(report)},
        "troubled": [test for test in report["tests"] if test["outcome"] in ("failed", "error", "not-run")],
        "violation": lambda found: explanation.violation(found, report.get("units", {})),
        "nearest_miss": explanation.nearest_miss,
        "styles": Markup("\n".join(_asset(f"{name}.css") for name in _STYLES)),
        "libraries": [Markup(_asset(f"vendor/{name}.js")) for name in ("d3.min", "plot.umd.min")],
        "scripts": Markup("\n".join(_asset(f"{name}.js") for name in _SCRIPTS)),
        "data": Markup(_json(_data(report, names))),
    }


def _data(report: Mapping[str, Any], names: list[str]) -> dict[str, Any]:
    """What the page's scripts work with."""
    return rows.index(report) | {
        "outcomeWords": _OUTCOME_WORDS,
        "packSize": details.TESTS_A_PACK,
        "curves": [{"closure": curves.closure(each), "learning": curves.learning(each)} for each in report["suites"]],
        "triggers": [curves.triggers(report, name) for name in names],
        "marginUnits": [judged.margin_unit(report, name) for name in names],
        "units": report.get("units", {}),
        "state": report.get("state", ""),
        "statements": [[file["file"], line] for file in _map(report) for line in file["statements"]],
        "cross": judged.cross(report),
        "smallest": closure.smallest(report),
    }


def _map(report: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    return list(report.get("code_under_test", {}).get("map", ()))


def _json(value: object) -> str:
    """JSON that can stand in a script element: nothing in it ends the element or begins a comment."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False, sort_keys=True)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


@cache
def _asset(name: str) -> str:
    return files(__package__).joinpath("page", name).read_text(encoding="utf-8")


def _merged(report: Mapping[str, Any]) -> tuple[int, int]:
    """Statements covered by all suites together, and all statements."""
    listed = report.get("code_under_test", {}).get("files", ())
    return sum(file["covered"] for file in listed), sum(file["statements"] for file in listed)
