"""The code under test as plain data, so that a report can be read, merged and closed where the code is not."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pytest_hricdv.cover.source import Bits, CodeMap, SourceFile, Waiver

Plain = dict[str, Any]


def list_code(code: CodeMap | None) -> Plain:
    """What a report holds of the code: its hash, its waivers, and per file the order of the bits, and the text."""
    if code is None:
        return {"sha256": "", "waivers": [], "map": []}
    return {
        "sha256": code.sha256,
        "waivers": [{"file": w.file, "line": w.line, "reason": w.reason} for w in code.waivers],
        "map": [
            {
                "file": file.name,
                "statements": list(file.statements),
                "branches": [list(arc) for arc in file.branches],
                "source": file.text,
            }
            for file in code.files
        ],
    }


def code_of(listed: Mapping[str, Any]) -> CodeMap | None:
    """The code that `list_code` listed, as far as coverage goes; None where nothing is listed."""
    files = []
    for file in listed.get("map", ()):
        name = file["file"]
        waivers = tuple(Waiver(**waiver) for waiver in listed["waivers"] if waiver["file"] == name)
        branches = tuple((origin, target) for origin, target in file["branches"])
        files.append(SourceFile(name, Path(name), tuple(file["statements"]), branches, waivers, file["source"]))
    return CodeMap(tuple(listed.get("packages", ())), tuple(files), listed["sha256"]) if files else None


def list_bits(bits: Bits) -> list[str | None]:
    """Bits as a test's entry has them: statements and branches, each as a hexadecimal number."""
    return [hex(bits.statements), None if bits.branches is None else hex(bits.branches)]


def bits_of(listed: Mapping[str, Any] | None) -> Bits | None:
    """The bits of a test's entry; None where it was not measured, or says only how much it covered."""
    if not listed or "bits" not in listed:
        return None
    statements, branches = listed["bits"]
    return Bits(int(statements, 16), None if branches is None else int(branches, 16))
