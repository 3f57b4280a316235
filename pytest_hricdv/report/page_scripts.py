"""The scripts and styles that `html` embeds in the page, of core and features, and the policy that forbids others."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from functools import cache
from hashlib import sha256
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Any

from markupsafe import Markup

from pytest_hricdv.report.view import views

_SCRIPTS = (
    "element",
    "address",
    "data",
    "tip",
    "table",
    "plots",
    "marks",
    "tests",
    "requirement",
    "filtered",
    "suites",
    "cross",
    "sources",
    "timeline",
    "lane_plots",
    "run_events",
    "run_window",
    "run_beside",
    "run",
    "behaviour",
    "issue",
    "test",
    "pages",
    "search",
    "main",
)
_STYLES = ("theme", "layout", "parts", "views")


def folder_of(part: str) -> Traversable:
    """The folder `page` of a feature, by the feature's name."""
    return files("pytest_hricdv").joinpath("extra", part, "page")


@cache
def styles() -> Markup:
    """The styles of the page."""
    return Markup("\n".join(asset(f"{name}.css") for name in _STYLES))


@cache
def inline_scripts() -> dict[str, Any]:
    """The page's own scripts, and its policy, which names each by its hash: a browser runs no other inline script.

    So neither an attribute with a handler nor a link to `javascript:` runs, should one ever get onto the page. The
    files of a large report's details are scripts next to it; `file:` stands for these where the page is opened from
    disk, where `'self'` is nothing.
    """
    first = 'document.documentElement.className = "scripted";'
    libraries = [asset(f"vendor/{name}.js") for name in ("d3.min", "plot.umd.min")]
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
    """The hash of a script in the form of a Content-Security-Policy."""
    return f"'sha256-{base64.b64encode(sha256(text.encode()).digest()).decode()}'"


def _scripts() -> Iterator[str]:
    """All scripts; features' scripts come before the core's last one, which starts to show the page."""
    yield from (asset(f"{name}.js") for name in _SCRIPTS[:-1])
    for view in views():
        yield from (folder_of(view.name).joinpath(f"{name}.js").read_text(encoding="utf-8") for name in view.scripts)
    yield asset(f"{_SCRIPTS[-1]}.js")


@cache
def asset(name: str) -> str:
    """A file of the core's page."""
    return files(__package__).joinpath("page", name).read_text(encoding="utf-8")
