"""A requirement of one's own in a draft: the edits that it takes, how many lines they are, and what comes of it.

The edits of each code base are in studies/code_bases/own/KEY.toml, made once by hand: `id` of the requirement, its
`source`, where it comes from, and for each edit a `file` with `new` lines in the place of `old` ones, or at its end.
"""

from __future__ import annotations

import difflib
import json
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from studies.code_bases import ROOT

FOLDER = ROOT / "studies" / "code_bases" / "own"

TESTS = 8
"""So many are run (chosen: one has each start and most manners)."""


class EditError(Exception):
    """A draft does not have what an edit replaces, or has it twice."""


@dataclass(frozen=True)
class Edit:
    """New text in a file, in the place of old text that is there once; at the end of the file where that is empty."""

    file: str
    new: str
    old: str = ""


@dataclass(frozen=True)
class Own:
    """A requirement, by its id, and the edits of a draft that it takes."""

    id: str
    edits: tuple[Edit, ...]


def own_requirement(key: str) -> Own:
    """That of a code base."""
    text = tomllib.loads((FOLDER / f"{key}.toml").read_text(encoding="utf-8"))
    return Own(text["id"], tuple(Edit(**edit) for edit in text["edit"]))


def edited(own: Own, folder: Path) -> int:
    """Edit a draft; how many lines were added and removed, each line that is changed being both.

    Raises:
        EditError: the draft does not have what an edit replaces, or has it twice.
    """
    return sum(_edited(edit, folder / edit.file) for edit in own.edits)


def _edited(edit: Edit, path: Path) -> int:
    before = path.read_text(encoding="utf-8")
    if edit.old and before.count(edit.old) != 1:
        raise EditError(f"{path}: expected this once, found it {before.count(edit.old)} times:\n{edit.old}")
    after = before.replace(edit.old, edit.new) if edit.old else before + edit.new
    path.write_text(after, encoding="utf-8")
    return sum(1 for _ in _changed(before, after))


def _changed(before: str, after: str) -> Iterator[str]:
    lines = difflib.unified_diff(before.splitlines(), after.splitlines(), n=0, lineterm="")
    yield from (line for number, line in enumerate(lines) if number > 1 and line[0] in "+-")


def checked(own: Own, folder: Path) -> str:
    """Run some tests of a draft; the verdict on the requirement, as the table has it.

    Raises:
        RuntimeError: the tests did not start.
    """
    command = [sys.executable, "-m", "pytest", "-q", "--hri-suite=rl", f"--hri-tests={TESTS}", "--hri-audit=off"]
    ran = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if ran.returncode > 1:
        raise RuntimeError(f"{folder.name}: the tests did not start:\n{ran.stdout[-2000:]}{ran.stderr[-2000:]}")
    report = json.loads((folder / "hri-report" / "report.json").read_text(encoding="utf-8"))
    return verdict(own.id, report)


def verdict(name: str, report: Mapping[str, Any]) -> str:
    """In how many tests a requirement was decided, and how; `not checked` where none triggered it."""
    results = [test["requirements"][name] for test in report["tests"] if name in test["requirements"]]
    failed = sum(bool(result["failures"]) for result in results)
    triggered = sum(bool(result["triggers"]) for result in results)
    if failed:
        return f"failed in {failed} of {len(results)} tests"
    return f"passed in {triggered} of {len(results)} tests" if triggered else "not checked"
