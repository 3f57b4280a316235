"""The held-out faults: drawn once, kept in `faults.json` by what they change."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from pytest_hricdv.coverage.code_map import CodeMap
from studies.fair_fight import FOLDER
from studies.localization.faults import Fault, FaultError, mutants

KEPT = FOLDER / "faults.json"
SEED, MOST = 2911, 10


def draw(folder: Path, code: CodeMap) -> list[dict[str, str]]:
    """Draw those of the code in a folder that was filled."""
    paths = {file.name: str(file.path.resolve().relative_to(folder.resolve())) for file in code.files}
    return [_kept(fault, paths[fault.file]) for fault in mutants(code, SEED, MOST)]


def _kept(fault: Fault, path: str) -> dict[str, str]:
    """The lines that differ: what both texts begin and end with is left out."""
    before, after = fault.before.splitlines(keepends=True), fault.text.splitlines(keepends=True)
    first = next(place for place, (old, new) in enumerate(zip(before, after, strict=False)) if old != new)
    last = 0
    while last < min(len(before), len(after)) - first and before[-1 - last] == after[-1 - last]:
        last += 1
    gone, came = before[first : len(before) - last], after[first : len(after) - last]
    return {
        "id": fault.id,
        "operator": fault.kind,
        "file": path,
        "line": str(first + 1),
        "before": "".join(gone),
        "after": "".join(came),
    }


def sealed(base: str) -> list[dict[str, str]]:
    """Those of a code base."""
    kept: Mapping[str, list[dict[str, str]]] = json.loads(KEPT.read_text(encoding="utf-8"))
    return kept[base]


def plant(fault: Mapping[str, str], folder: Path) -> None:
    """Put a fault into the code of a folder. Raises FaultError where it does not fit."""
    path, first = folder / fault["file"], int(fault["line"]) - 1
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    before = fault["before"].splitlines(keepends=True)
    if lines[first : first + len(before)] != before:
        raise FaultError(f"{KEPT.name}: {fault['id']}: {fault['file']}:{fault['line']} is another text")
    lines[first : first + len(before)] = fault["after"].splitlines(keepends=True)
    path.write_text("".join(lines), encoding="utf-8")
