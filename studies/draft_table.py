"""The table of docs/studies/drafts.md: what was measured of each code base, and its file.

Some figures take seconds and others many minutes, and some need packages that are not part of this project. So each
command notes what it has measured, and the page is made of all that is noted.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pytest_hricdv._base import atomic_file
from studies.code_bases import KINDS, ROOT, CodeBase
from studies.page import replace_figures, table

PAGE = ROOT / "docs" / "studies" / "drafts.md"
NOTED = ROOT / "studies" / "code_bases" / "measured.json"
COMMAND = "python -m studies.drafts"
FOUND = ("code", *(f"{kind}: found, right, declared" for kind in KINDS))
EFFORT = ("code", "draft", "first green run after", "lines added or removed", "own requirement")
FAULTS = ("code", "noticed by the draft alone", "with ten suggestions, which they ranked", "of as many others")

Noted = dict[str, dict[str, Any]]
"""Key of a code base -> its name, and what was measured."""


def noted(path: Path = NOTED) -> Noted:
    """What was measured so far."""
    measured: Noted = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    return measured


def note(code: CodeBase, figures: Mapping[str, Any], path: Path = NOTED) -> None:
    """Note what was measured of a code base, in the place of what was measured of the same before."""
    measured = noted(path)
    measured[code.key] = {**measured.get(code.key, {}), "name": code.name, **figures}
    atomic_file.write_text(path, json.dumps(measured, indent=2, ensure_ascii=False) + "\n")


def write_page(path: Path = PAGE) -> str:
    """Write the page; returns its tables."""
    text = tables(noted())
    replace_figures(path, COMMAND, text)
    return text


def tables(measured: Noted) -> str:
    """The tables: what is found, how long it takes to a requirement of one's own, and which faults are noticed.

    A dash is not measured.
    """
    found = [[figures["name"], *(figures["found"][kind] for kind in KINDS)]
             for figures in measured.values() if "found" in figures]  # fmt: skip
    effort = [[figures["name"], *_effort(figures)] for figures in measured.values()]
    parts = [table(FOUND, found)]
    if any(cell != "-" for row in effort for cell in row[1:]):
        parts.append(table(EFFORT, effort))
    faults = [
        [figures["name"], *_faults(figures)]
        for figures in measured.values()
        if {"alone", "ranking_faults", "faults"} & {*figures}
    ]
    if faults:
        parts.append(table(FAULTS, faults))
    return "\n\n".join(parts)


def _effort(figures: Mapping[str, Any]) -> Iterator[str]:
    yield f"{figures['draft_s']} s" if "draft_s" in figures else "-"
    yield f"{figures['green_s']} s" if "green_s" in figures else "-"
    yield str(figures["edited_lines"]) if "edited_lines" in figures else "-"
    yield figures.get("own", "-")


def _faults(figures: Mapping[str, Any]) -> Iterator[str]:
    for which in ("alone", "ranking_faults", "faults"):
        noticed, of = figures.get(which, (0, 0))
        yield f"{noticed} of {of} ({100 * noticed / of:.0f} %)" if of else "-"
