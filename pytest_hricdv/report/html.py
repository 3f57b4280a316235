"""The HTML report: a page that needs no network, made from the report alone; of a large report, files beside it."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from hashlib import sha256
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Any, Literal, get_args
from urllib.parse import quote

import jinja2
from markupsafe import Markup

from pytest_hricdv._base import own_json as json
from pytest_hricdv._base.message import visible
from pytest_hricdv.execution.outcome import OUTCOMES
from pytest_hricdv.report import behaviour_view, explanation, formatting, holes_view, tests_view, totals, waivers_view
from pytest_hricdv.report.hole_causes import hole_causes
from pytest_hricdv.report.margin import margin_text, margin_unit
from pytest_hricdv.report.navigation import areas, suites_heading
from pytest_hricdv.report.requirement_view import drawn_texts, grouped, requirement_view, states, triggers_over_time
from pytest_hricdv.report.sheet import Sheet, css_text, sheet
from pytest_hricdv.report.sources_view import CoverageCount, code_sources, model_sources
from pytest_hricdv.report.verdict import verdict
from pytest_hricdv.report.view import Place, views
from pytest_hricdv.report.violation_lines import violation_line
from pytest_hricdv.results.behaviour_diff import headline
from pytest_hricdv.results.model import Report, SuiteResult, TestResult

EMBEDDED_BYTES = 1_200_000
"""If the tests' details are larger, they are written to files beside the page, so that it opens fast."""

_SHOWN_ITEMS = 40
"""Of a gap, before the rest is folded away; chosen: some lines of a browser."""
_SHOWN_HOLES = 15
"""Groups of points that no test covers, before the rest is folded away; chosen: each is a line or two, so a screen."""
_SCRIPTS = (
    "element",
    "address",
    "data",
    "tip",
    "table",
    "plots",
    "tests",
    "requirement",
    "requirements",
    "suites",
    "closure",
    "cross",
    "sources",
    "timeline",
    "lane_plots",
    "run_events",
    "run_window",
    "run_beside",
    "run",
    "behaviour",
    "test",
    "pages",
    "main",
)
_STYLES = ("theme", "layout", "parts", "views")
COLUMNS = 400
"""Of a curve: about as many as a plot is pixels wide on half of a screen, so that thinning is not seen."""
Kind = Literal["statements", "branches", "plans"]
KINDS: tuple[Kind, ...] = ("statements", "branches", "plans")
_LEAST_CHANGE = 1e-12  # smaller changes are rounding errors and would only stretch a logarithmic axis

Point = tuple[float, float]
Places = Sequence[Mapping[str, int]]
"""Of each coordinate: bin -> number."""


def page(report: Report) -> tuple[str, dict[str, str]]:
    """The page, and the files beside it: name relative to the page -> text. Equal reports give equal text."""
    packs = list(tests_view.packs(report))
    embedded = sum(map(len, packs)) <= EMBEDDED_BYTES
    template = _environment().get_template("index.html.jinja")
    text = template.render(_context(report), packs=packs if embedded else [], **_inline_scripts())
    beside = {tests_view.pack_name(n): f'hricdvPack({n},"{pack}")\n' for n, pack in enumerate(packs)}
    return text, {} if embedded else beside


@cache
def _environment() -> jinja2.Environment:
    """One for all pages: it keeps the compiled templates, which take longer to compile than to fill in."""
    environment = jinja2.Environment(
        loader=jinja2.ChoiceLoader([jinja2.PackageLoader("pytest_hricdv", "report/page"), _loader_of_parts()]),
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
        outcome=totals.outcome_word,
        outcome_style=totals.outcome_style,
        coded=_coded,
    )
    return environment


def _loader_of_parts() -> jinja2.BaseLoader:
    """Finds the template `PART/NAME` in the folder `page` of a part."""
    names = [view.name for view in views() if _folder_of(view.name).is_dir()]
    return jinja2.PrefixLoader({name: jinja2.PackageLoader(f"pytest_hricdv.extra.{name}", "page") for name in names})


def _folder_of(part: str) -> Traversable:
    return files("pytest_hricdv").joinpath("extra", part, "page")


def _finalize(value: object) -> object:
    """Applied by jinja2 to every value before it escapes it: no invisible character gets onto the page."""
    return visible(value, keep="\n\t") if isinstance(value, str) and not isinstance(value, Markup) else value


def _coded(text: str) -> Markup:
    """Text with what stands between backquotes as code."""
    parts = visible(text).split("`")
    return Markup("").join(Markup("<code>{}</code>").format(part) if n % 2 else part for n, part in enumerate(parts))


def _address(name: str) -> str:
    """A name as a part of a link within the page."""
    return quote(name.encode("utf-8", "backslashreplace"), safe="")


def _context(report: Report) -> dict[str, Any]:
    names = tests_view.requirement_names(report)
    requirements = [requirement_view(report, name) for name in names]
    sections = [section for view in views() if (section := view.section(report)) is not None]
    origins = [origin for origin in (report.origin, *(s.origin for s in report.sessions)) if origin is not None]
    signed = sheet(report, requirements, origins)
    return {
        "report": report,
        "code": report.code_under_test,
        "outcomes": totals.outcomes(report),
        "loss": totals.loss(report),
        "nothing_checked": totals.nothing_checked(report),
        "duration": totals.duration(report),
        "suites": report.suites,
        "holes": hole_causes(report),
        "shown_holes": _SHOWN_HOLES,
        "aim": next((command for view in views() if (command := view.aim(report))), ""),
        "shown_items": _SHOWN_ITEMS,
        "waivers": waivers_view.waivers(report),
        "unmeasured": totals.unmeasured(report),
        "origins": origins,
        "sheet": signed,
        "paper": Markup(_paper(report, signed)),
        "plans_covered": totals.plans_covered,
        "bins_covered": totals.bins_covered,
        "tests_text": totals.tests_text,
        "share": formatting.share,
        "plural": formatting.plural,
        "requirements": requirements,
        "requirement_groups": grouped(requirements),
        "no_count": CoverageCount(),
        "sources": {"code": code_sources(report), "plans": model_sources(report)},
        "failing": [test for test in report.tests if test.fails or test.outcome == "not-run"],
        "behaviour": behaviour_view.examples(report),
        "headline": headline,
        "all_sections": sections,
        "sections": {place: [section for section in sections if section.place == place] for place in get_args(Place)},
        "verdict": verdict(report),
        "areas": areas(report, sections),
        "suites_heading": suites_heading(report),
        "states": states(requirements),
        "tests_by_nodeid": {test.nodeid: test for test in report.tests},
        "replay_command": lambda file: explanation.replay_command(file, report.rerun.options),
        "violation": lambda name, violation: violation_line(violation, report.units or {}, margin_unit(report, name)),
        "nearest_miss": explanation.nearest_miss,
        "margin": lambda name, value: margin_text(value, margin_unit(report, name)),
        "styles": Markup("\n".join(_asset(f"{name}.css") for name in _STYLES)),
        "data": Markup(_json(_data(report, names))),
    }


def _paper(report: Report, signed: Sheet) -> str:
    """The style of printed pages: each has the project, the date, the revision, and its number."""
    texts = {
        "top-left": css_text(f"{report.testbench}: verification by pytest-hricdv {report.version}"),
        "top-right": css_text(signed.date),
        "bottom-left": css_text(f"revision {signed.revision}" if signed.revision else "no revision known"),
        "bottom-right": '"page " counter(page) " of " counter(pages)',
    }
    boxes = " ".join(
        f"@{place} {{ content: {text}; font: 8pt sans-serif; color: #444; }}" for place, text in texts.items()
    )
    return f"@page {{ margin: 16mm 14mm; {boxes} }}"


def _data(report: Report, names: list[str]) -> dict[str, Any]:
    """Plain data for the page's scripts."""
    curves = [{"closure": closure_curves(suite), "learning": learning_curve(suite)} for suite in report.suites]
    return (
        tests_view.index(report)
        | {
            "outcomeWords": {outcome: totals.outcome_word(outcome) for outcome in OUTCOMES},
            "outcomeStyles": {outcome: totals.outcome_style(outcome) for outcome in OUTCOMES},
            "outcomeLabel": report.outcome_label,
            "titles": {name: texts.title for name, texts in report.requirements.items() if texts.title},
            "failedFor": tests_view.failed_for(report),
            "packSize": tests_view.TESTS_PER_PACK,
            "curves": curves,
            "triggers": [triggers_over_time(report, name) for name in names],
            "marginUnits": [margin_unit(report, name) for name in names],
            "texts": [drawn_texts(report, name) for name in names],
            "units": report.units or {},
            "sampledWhile": report.sampled_while,
            "state": report.state,
            "statements": [(file.file, line) for file in report.code_under_test.map for line in file.statements],
            "cross": heat_maps(report),
            "minimal": minimal_suite(report),
            "changes": behaviour_view.index(report),
        }
        | {key: value for view in views() for key, value in view.data(report).items()}
    )


def _json(value: object) -> str:
    """JSON that can stand in a script element: nothing in it ends the element or begins a comment."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False, sort_keys=True)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


@cache
def _inline_scripts() -> dict[str, Any]:
    """The page's own scripts, and its policy, which names each by its hash: a browser runs no other inline script.

    So neither an attribute with a handler nor a link to `javascript:` runs, should one ever get onto the page. The
    files of a large report's details are scripts beside it; `file:` stands for these where the page is opened from
    disk, where `'self'` is nothing.
    """
    first = 'document.documentElement.className = "scripted";'
    libraries = [_asset(f"vendor/{name}.js") for name in ("d3.min", "plot.umd.min")]
    own = '\n(function () {\n"use strict";\n' + "\n".join(_scripts()) + "\n})();\n"
    hashes = " ".join(map(_hash_of_script, (first, *libraries, own)))
    policy = (
        f"default-src 'none'; script-src {hashes} 'self' file:; "
        "style-src 'unsafe-inline'; img-src data: 'self' file:; media-src 'self' file:; base-uri 'none'; "
        "form-action 'none'"
    )
    scripts = {"first_script": first, "libraries": libraries, "own_script": own}
    safe = {name: [*map(Markup, text)] if isinstance(text, list) else Markup(text) for name, text in scripts.items()}
    return {"policy": Markup(policy), **safe}


def _hash_of_script(text: str) -> str:
    """As a Content-Security-Policy has it."""
    return f"'sha256-{base64.b64encode(sha256(text.encode()).digest()).decode()}'"


def _scripts() -> Iterator[str]:
    """Those of the parts are before the last one of the core, which begins to show the page."""
    yield from (_asset(f"{name}.js") for name in _SCRIPTS[:-1])
    for view in views():
        yield from (_folder_of(view.name).joinpath(f"{name}.js").read_text(encoding="utf-8") for name in view.scripts)
    yield _asset(f"{_SCRIPTS[-1]}.js")


@cache
def _asset(name: str) -> str:
    return files(__package__).joinpath("page", name).read_text(encoding="utf-8")


def closure_curves(suite: SuiteResult) -> dict[str, list[Point]]:
    """Kind of coverage -> (tests run, per cent covered by them together); without kinds that were not measured."""
    curves: dict[str, list[Point]] = {}
    for kind in KINDS:
        total = _total(suite, kind)
        steps = [(step.tests, getattr(step, kind)) for step in suite.curve]
        if total and steps:
            curves[kind] = thinned([(tests, round(100.0 * covered / total, 2)) for tests, covered in steps])
    return curves


def learning_curve(suite: SuiteResult) -> list[Point]:
    """(iteration, largest change of Q); a change of 0, which has no logarithm, counts as the least change."""
    changes = enumerate(suite.generation.q_delta, start=1)
    return thinned([(number, float(f"{max(change, _LEAST_CHANGE):.4g}")) for number, change in changes])


def minimal_suite(report: Report) -> dict[str, Any]:
    """The smallest suite with the coverage of all tests.

    Returns:
        `curve`: (simulated s, points covered) test by test, `growth`: the same of all tests in the report's order,
        `points` and `sim_s` of all tests, `gains`: number of a test in the report -> points that it adds, of the tests
        of the smallest suite, `unique`: the same with the points that no other test covers.
    """
    closure = report.closure
    numbers = {test.nodeid: number for number, test in enumerate(report.tests)}
    curve: list[Point] = [(0.0, 0.0), *((round(step.sim_s, 2), step.points) for step in closure.minimal)]
    growth: list[Point] = [(0.0, 0.0), *((round(sim_s, 2), points) for sim_s, points in closure.growth)]
    growth.append((round(closure.sim_s, 2), closure.points))
    return {
        "curve": thinned(curve),
        "growth": thinned(growth),
        "points": closure.points,
        "sim_s": closure.sim_s,
        "gains": {numbers[step.nodeid]: step.gain for step in closure.minimal if step.nodeid in numbers},
        "unique": {numbers[name]: count for name, count in closure.unique.items() if name in numbers},
    }


def heat_maps(report: Report) -> list[dict[str, Any]]:
    """The cross products, each with what its heat map needs.

    Returns:
        `name`, `coordinates` ([name, bins] each), `closed` (["impossible" or "illegal", reason, bit set of bins as a
        hexadecimal number] each), `suites` (suite -> [bin, tests that hit it] each), `tests` (the bins that each
        test of the report hit), `proof`, `holes` (in words). Bins are numbered, the last coordinate's fastest.
    """
    maps = []
    for name, product in sorted(report.cross_products.items()):
        coordinates = [(coordinate.name, coordinate.bins) for coordinate in product.coordinates]
        places = [{name: number for number, name in enumerate(bins)} for _, bins in coordinates]
        closed: dict[tuple[str, str], int] = {}
        for kind, bins in (("impossible", product.impossible), ("illegal", product.illegal)):
            for record in bins:
                closed[kind, record.reason] = closed.get((kind, record.reason), 0) | 1 << _number(record.bin, places)
        maps.append(
            {
                "name": name,
                "coordinates": coordinates,
                "closed": [(kind, reason, f"{bits:x}") for (kind, reason), bits in closed.items()],
                "suites": {suite.name: _suite_hits(suite, name, places) for suite in report.suites},
                "tests": [_test_hits(test, name, places) for test in report.tests],
                "proof": product.proof.reason or "",
                "holes": holes_view.of_all_suites(report, name),
            }
        )
    return maps


def thinned(points: Sequence[Point], columns: int = COLUMNS) -> list[Point]:
    """At most two points per column, the lowest and the highest: a long curve keeps its shape in fewer bytes."""
    if len(points) <= 2 * columns:
        return list(points)
    kept: list[Point] = [points[0]]
    for column in range(columns):
        part = points[column * len(points) // columns : (column + 1) * len(points) // columns]
        kept += sorted({min(part, key=_height), max(part, key=_height)})
    return [*kept, points[-1]]


def _height(point: Point) -> float:
    return point[1]


def _total(suite: SuiteResult, kind: Kind) -> int:
    if kind == "plans":
        return sum(agent.total for agent in suite.plans.values())
    coverage = suite.code.statements if kind == "statements" else suite.code.branches
    return coverage.total if coverage else 0


def _suite_hits(suite: SuiteResult, product: str, places: Places) -> list[tuple[int, int]]:
    coverage = suite.cross.products.get(product)
    return [(_number(hit.bin, places), hit.tests) for hit in coverage.hits] if coverage else []


def _test_hits(test: TestResult, product: str, places: Places) -> list[int]:
    hits = (test.cross or {}).get(product, ())
    return sorted({_number(hit, places) for hit in hits})


def _number(combination: Sequence[str], places: Places) -> int:
    number = 0
    for part, numbers in zip(combination, places, strict=True):
        number = number * len(numbers) + numbers[part]
    return number
