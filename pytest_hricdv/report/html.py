"""The HTML report: `page` makes a self-contained page from a report, which `report.files` writes as `index.html`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, get_args
from urllib.parse import quote

import jinja2
from markupsafe import Markup

from pytest_hricdv._base import own_json as json
from pytest_hricdv._base.message import visible
from pytest_hricdv.execution.outcome import OUTCOMES
from pytest_hricdv.report import behaviour_view, explanation, formatting, tests_view, totals, waivers_view
from pytest_hricdv.report.holes import hole_causes
from pytest_hricdv.report.page_scripts import folder_of, inline_scripts, styles
from pytest_hricdv.report.plot_data import closure_curves, heat_maps, learning_curve, minimal_suite
from pytest_hricdv.report.requirement_view import (
    group_requirements,
    plot_texts,
    requirement_view,
    states,
    triggers_over_time,
)
from pytest_hricdv.report.sheet import Sheet, css_text, sheet
from pytest_hricdv.report.sources_view import CoverageCount, code_sources, model_sources
from pytest_hricdv.report.suite_figures import suite_figures
from pytest_hricdv.report.verdict import verdict
from pytest_hricdv.report.view import PageSection, Place, views
from pytest_hricdv.report.violations import margin_text, margin_unit, violation_line
from pytest_hricdv.results.behaviour_diff import headline
from pytest_hricdv.results.model import Report

EMBEDDED_BYTES = 1_200_000
"""Most characters of the tests' details in the page; beyond it, they are in files next to it, so that it opens fast."""


def page(report: Report) -> tuple[str, dict[str, str]]:
    """The page, and the files next to it: name relative to the page -> text. Equal reports give equal text."""
    packs = list(tests_view.packs(report))
    embedded = sum(map(len, packs)) <= EMBEDDED_BYTES
    template = _environment().get_template("index.html.jinja")
    text = template.render(_context(report), packs=packs if embedded else [], **inline_scripts())
    files = {tests_view.pack_name(n): f'hricdvPack({n},"{pack}")\n' for n, pack in enumerate(packs)}
    return text, {} if embedded else files


def standalone(package: str, template: str, **values: object) -> str:
    """A document of its own, from a template in the folder of a package."""
    return _environment_of(jinja2.PackageLoader(package, ".")).get_template(template).render(**values)


@cache
def _environment() -> jinja2.Environment:
    """The environment for all pages: it keeps the compiled templates, as compiling takes longer than filling in."""
    pages = jinja2.PackageLoader("pytest_hricdv", "report/page")
    environment = _environment_of(jinja2.ChoiceLoader([pages, _loader_of_parts()]))
    environment.filters.update(
        percent=formatting.percent,
        seconds=formatting.seconds,
        quantity=formatting.quantity,
        anchor=tests_view.anchor,
        address=_address,
        speedup=formatting.speedup,
        outcome=totals.outcome_word,
        outcome_style=totals.outcome_style,
        coded=_mark_code,
        capitalized=formatting.capitalize,
        utc=formatting.utc,
    )
    return environment


def _environment_of(loader: jinja2.BaseLoader) -> jinja2.Environment:
    return jinja2.Environment(
        loader=loader,
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        finalize=_finalize,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )


def _loader_of_parts() -> jinja2.BaseLoader:
    """Finds the template `PART/NAME` in the folder `page` of a feature."""
    names = [view.name for view in views() if folder_of(view.name).is_dir()]
    return jinja2.PrefixLoader({name: jinja2.PackageLoader(f"pytest_hricdv.extra.{name}", "page") for name in names})


def _finalize(value: object) -> object:
    """Applied by jinja2 to every value before it escapes it: no invisible character gets onto the page."""
    return visible(value, keep="\n\t") if isinstance(value, str) and not isinstance(value, Markup) else value


def _mark_code(text: str) -> Markup:
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
        "nothing_checked": totals.list_vacuity_warnings(report),
        "duration": totals.duration(report),
        "suites": report.suites,
        "suite_figures": suite_figures,
        "holes": hole_causes(report),
        "shown_holes": 15,
        "aim": next((command for view in views() if (command := view.aim(report))), ""),
        "shown_items": 40,
        "waivers": waivers_view.list_waivers(report),
        "unmeasured": totals.explain_no_coverage(report),
        "origins": origins,
        "sheet": signed,
        "paper": Markup(_paper(report, signed)),
        "plans_covered": totals.plans_covered,
        "bins_covered": totals.bins_covered,
        "tests_text": totals.tests_text,
        "share": formatting.share,
        "plural": formatting.plural,
        "requirements": requirements,
        "requirement_groups": group_requirements(requirements),
        "no_count": CoverageCount(),
        "sources": {"code": code_sources(report), "plans": model_sources(report)},
        "failing": sorted(
            (test for test in report.tests if test.fails or test.outcome == "not-run"),
            key=lambda test: test.outcome == "not-run",  # there may be many, which say nothing yet
        ),
        "behaviour": behaviour_view.examples(report),
        "headline": headline,
        "all_sections": sections,
        "sections": {place: [section for section in sections if section.place == place] for place in get_args(Place)},
        "verdict": verdict(report),
        "areas": areas(report, sections),
        "suites_heading": suites_heading(report),
        "states": states(requirements),
        "tests_by_nodeid": {test.nodeid: test for test in report.tests},
        "replay_command": lambda file: explanation.replay_command(file, report.rerun_options.options),
        "violation": lambda name, violation: violation_line(violation, report.units or {}, margin_unit(report, name)),
        "near_miss": explanation.near_miss,
        "margin": lambda name, value: margin_text(value, margin_unit(report, name)),
        "styles": styles(),
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
            "failedFor": tests_view.index_causes(report),
            "made": _describe_versions(report),
            "packSize": tests_view.TESTS_PER_PACK,
            "curves": curves,
            "triggers": [triggers_over_time(report, name) for name in names],
            "marginUnits": [margin_unit(report, name) for name in names],
            "texts": [plot_texts(report, name) for name in names],
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


def _describe_versions(report: Report) -> str:
    """The versions and the revision of a report: `pytest-hricdv 0.1.0, python 3.12.1; revision 1f2e3d`."""
    origin = report.origin or next((session.origin for session in report.sessions if session.origin), None)
    if origin is None:
        return f"pytest-hricdv {report.version}"
    versions = ", ".join(f"{name} {version}" for name, version in sorted(origin.versions.items()))
    return f"{versions}; revision {origin.revision}" if origin.revision else versions


def _json(value: object) -> str:
    """JSON that can stand in a script element: nothing in it ends the element or begins a comment."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False, sort_keys=True)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


# Navigation: at most seven entries, whatever a report has


@dataclass(frozen=True)
class Link:
    """A view of the page: the id of its element, which is its address, and its title."""

    id: str
    title: str


@dataclass(frozen=True)
class Area:
    """An entry of the navigation: its title, and its views, the first of which it opens."""

    title: str
    links: tuple[Link, ...]


def areas(report: Report, sections: Sequence[PageSection]) -> tuple[Area, ...]:
    """The entries in their order.

    Args:
        report: the report whose page it is.
        sections: the sections of features; those without a title are parts of other views.
    """
    return tuple(area for area in _list_areas(report, sections) if area.links)


def _list_areas(report: Report, sections: Sequence[PageSection]) -> Iterator[Area]:
    further = _links(sections, "further")
    yield Area("Summary", (Link("summary", "Summary"),))
    yield Area("Causes", _links(sections, "causes"))
    yield Area("Tests", (Link("tests", "Tests"),))
    yield Area("Requirements", (Link("requirements", "Requirements"), *_links(sections, "requirements")))
    yield Area("Coverage", (Link("closure", "Closure"), *_coverage_links(report)))
    # A single view needs no heading.
    yield Area(further[0].title if len(further) == 1 else "More", further)
    yield Area("Sheet", (Link("sheet", "Sheet to sign"),))


def _coverage_links(report: Report) -> Iterator[Link]:
    yield Link("code", "Code")
    if report.models:
        yield Link("plans", "Plans")
    if report.cross_products:
        yield Link("cross", "Cross products")
    yield Link("suites", suites_title(report))


def suites_title(report: Report) -> str:
    """The title of the view of suites: a single one is not compared."""
    return "Suites compared" if len(report.suites) != 1 else "Growth"


def suites_heading(report: Report) -> str:
    """`Suite rl, 134 tests: how coverage grew`, or `Suites compared`."""
    if len(report.suites) != 1:
        return "Suites compared"
    return f"Suite {report.suites[0].name}, {formatting.plural(report.suites[0].tests, 'test')}: how coverage grew"


def _links(sections: Sequence[PageSection], place: str) -> tuple[Link, ...]:
    return tuple(Link(section.id, section.title) for section in sections if section.place == place and section.title)
