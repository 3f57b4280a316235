"""The HTML report: a page that needs no network, made from the report alone; of a large report, files beside it."""

import json
from collections.abc import Sequence
from functools import cache
from importlib.resources import files
from typing import Any
from urllib.parse import quote

import jinja2
from markupsafe import Markup

from pytest_hricdv.report import explanation, formatting, plot_data, tests_view, totals
from pytest_hricdv.report.requirement_view import margin_unit, requirement_view, triggers_over_time
from pytest_hricdv.report.source_view import code_sources, model_sources
from pytest_hricdv.results.model import Report

EMBEDDED_BYTES = 1_200_000
"""If the tests' details are larger, they are written to files beside the page, so that it opens fast."""

_SHOWN_ITEMS = 40
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


def page(report: Report) -> tuple[str, dict[str, str]]:
    """The page, and the files beside it: name relative to the page -> text. Equal reports give equal text."""
    packs = list(tests_view.packs(report))
    embedded = sum(map(len, packs)) <= EMBEDDED_BYTES
    template = _environment(report.rerun.options).get_template("index.html.jinja")
    text = template.render(_context(report), packs=packs if embedded else [])
    beside = {tests_view.pack_name(n): f'hricdvPack({n},"{pack}")\n' for n, pack in enumerate(packs)}
    return text, {} if embedded else beside


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
        percent=formatting.percent,
        seconds=formatting.seconds,
        quantity=formatting.quantity,
        anchor=tests_view.anchor,
        address=_address,
        speedup=formatting.speedup,
        replay_command=lambda file: explanation.replay_command(file, options),
        outcome=_OUTCOME_WORDS.__getitem__,
    )
    return environment


def _finalize(value: object) -> object:
    """Applied by jinja2 to every value before it escapes it: no invisible character gets onto the page."""
    return formatting.visible(value, keep="\n\t") if isinstance(value, str) and not isinstance(value, Markup) else value


def _address(name: str) -> str:
    """A name as a part of a link within the page."""
    return quote(name.encode("utf-8", "backslashreplace"), safe="")


def _context(report: Report) -> dict[str, Any]:
    names = tests_view.requirement_names(report)
    return {
        "report": report,
        "code": report.code_under_test,
        "merged": totals.statements_covered(report),
        "outcomes": totals.outcomes(report),
        "loss": totals.loss(report),
        "duration": totals.duration(report),
        "suites": [(suite, totals.requirement_rows(report, suite)) for suite in report.suites],
        "gaps": totals.explained_gaps(report),
        "shown_items": _SHOWN_ITEMS,
        "waivers": totals.waivers(report),
        "unmeasured": totals.unmeasured(report),
        "plans_covered": totals.plans_covered,
        "bins_covered": totals.bins_covered,
        "share": formatting.share,
        "plural": formatting.plural,
        "requirements": [requirement_view(report, name) for name in names],
        "sources": {"code": code_sources(report), "plans": model_sources(report)},
        "failing": [test for test in report.tests if test.outcome in ("failed", "error", "not-run")],
        "violation": lambda found: explanation.violation(found, report.units or {}),
        "nearest_miss": explanation.nearest_miss,
        "styles": Markup("\n".join(_asset(f"{name}.css") for name in _STYLES)),
        "libraries": [Markup(_asset(f"vendor/{name}.js")) for name in ("d3.min", "plot.umd.min")],
        "scripts": Markup("\n".join(_asset(f"{name}.js") for name in _SCRIPTS)),
        "data": Markup(_json(_data(report, names))),
    }


def _data(report: Report, names: list[str]) -> dict[str, Any]:
    """Plain data for the page's scripts."""
    curves = [
        {"closure": plot_data.closure_curves(suite), "learning": plot_data.learning_curve(suite)}
        for suite in report.suites
    ]
    return tests_view.index(report) | {
        "outcomeWords": _OUTCOME_WORDS,
        "outcomeLabel": report.outcome_label,
        "packSize": tests_view.TESTS_PER_PACK,
        "curves": curves,
        "triggers": [triggers_over_time(report, name) for name in names],
        "marginUnits": [margin_unit(report, name) for name in names],
        "units": report.units or {},
        "state": report.state,
        "statements": [(file.file, line) for file in report.code_under_test.map for line in file.statements],
        "cross": plot_data.heat_maps(report),
        "minimal": plot_data.minimal_suite(report),
    }


def _json(value: object) -> str:
    """JSON that can stand in a script element: nothing in it ends the element or begins a comment."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False, sort_keys=True)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


@cache
def _asset(name: str) -> str:
    return files(__package__).joinpath("page", name).read_text(encoding="utf-8")
