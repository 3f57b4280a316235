"""Draw docs/pictures/architecture.svg: the packages of the plugin, as far up as what they import puts them.

    python -m studies.architecture

Lines lead down to what is imported; one that follows from two others is left out. The picture is made from the imports
of the code alone, not from the layers that pyproject.toml demands: `lint-imports` checks these.
"""

from __future__ import annotations

import math
import sys
import tomllib
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from xml.sax.saxutils import escape

import grimp

from studies.site import public_names

ROOT = Path(__file__).parents[1]
PICTURE = ROOT / "docs" / "pictures" / "architecture.svg"
PLUGIN, EXTRA = "pytest_hricdv", "extra"
CROSS_CHECK = ("controller", "sim")
"""Packages of the repository that are drawn with the plugin: the code under test and its world."""
COMMANDS = ("__main__", "campaign", "ros2")
"""Modules that only make `python -m pytest_hricdv...` work."""

Imports = Mapping[str, frozenset[str]]
"""Package -> the packages that it imports."""

# Sizes in pixels, chosen so that names fit, and the picture fits the column of the site (730 pixels).
_BOX, _GAP, _ROW, _CHARACTER, _MARGIN = 24, 14, 50, 7.3, 16
_WIDTH = 860
_FILLS = {"library": "#d7e8f7", "core": "#eeeeee", "extra": "#fbe6c8", "public": "#d9efd7", "beside": "#ffffff"}
_KEYS = {
    "public": "what users import",
    "core": "the core",
    "library": "libraries of their own",
    "extra": "optional features, in extra/",
    "beside": "the table assembly",
}


def imports() -> Imports:
    """What the packages import, as the code is now."""
    graph = grimp.build_graph(PLUGIN, *CROSS_CHECK, cache_dir=None)
    found: dict[str, set[str]] = defaultdict(set)
    exceptions = excepted()
    for importer in graph.modules:
        package = package_of(importer)
        found[package]  # also one that imports nothing
        for imported in graph.find_modules_directly_imported_by(importer):
            if (importer, imported) not in exceptions:
                found[package].add(package_of(imported))
    return {package: frozenset(found[package] - {package, ""}) for package in found if package}


def excepted() -> set[tuple[str, str]]:
    """Imports that the contracts of pyproject.toml except, importer and imported."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"][
        "contracts"
    ]
    arrows = [arrow for contract in contracts for arrow in contract.get("ignore_imports", ())]
    return {(importer, imported) for importer, _, imported in (arrow.partition(" -> ") for arrow in arrows)}


def package_of(module: str) -> str:
    """The package or module that stands for a module in the picture; empty for what is not drawn."""
    root, *rest = module.split(".")
    if root != PLUGIN:
        return root
    if not rest or rest[0] in COMMANDS or rest == [EXTRA]:
        return ""
    return "/".join(rest[:2]) if rest[0] == EXTRA else rest[0]


def levels(imported: Imports) -> dict[str, int]:
    """How far up each package stands: 0 for one that imports none, otherwise above all that it imports."""

    @cache
    def level(package: str) -> int:
        return 1 + max(map(level, imported[package]), default=-1)

    return {package: level(package) for package in imported}


def reduced(imported: Imports) -> Imports:
    """The imports without those that follow from two others (transitive reduction)."""

    @cache
    def below(package: str) -> frozenset[str]:
        return imported[package].union(*map(below, imported[package]))

    return {
        package: frozenset(each for each in direct if not any(each in below(other) for other in direct))
        for package, direct in imported.items()
    }


def kind(package: str) -> str:
    """Which of the groups in the key a package belongs to."""
    if package in CROSS_CHECK:
        return "beside"
    if package.startswith(f"{EXTRA}/"):
        return "extra"
    if package in ("bdi", "monitor", "runtime"):
        return "library"
    return "public" if f"{PLUGIN}.{package}" in public_names.listed() else "core"


@dataclass(frozen=True)
class Box:
    """A package in the picture: its name, and its left and upper edge (pixels)."""

    name: str
    left: float
    top: float

    @property
    def width(self) -> float:
        return _width(self.name)

    @property
    def middle(self) -> float:
        return self.left + self.width / 2


def boxes(imported: Imports) -> dict[str, Box]:
    """Where each package is drawn: near to what it imports, in a row per level, or several where one is too wide."""
    level = levels(imported)
    placed: dict[str, Box] = {}
    height = 0  # rows so far, from the bottom
    for number in range(max(level.values()) + 1):
        members = sorted(
            (name for name in level if level[name] == number),
            key=lambda name: (name.startswith(EXTRA), kind(name) == "beside", _centre(imported[name], placed), name),
        )
        for row in _rows(members):
            left = _left(row, imported, placed, _total(row))
            for name in row:
                placed[name] = Box(name, left, -height * _ROW)
                left += _width(name) + _GAP
            height += 1
    return {name: replace(box, top=box.top + _MARGIN + (height - 1) * _ROW) for name, box in placed.items()}


def _rows(members: list[str]) -> Iterator[list[str]]:
    """A level in rows that fit the picture, none much shorter than the others."""
    count = math.ceil((_total(members) + _GAP) / (_WIDTH - 2 * _MARGIN + _GAP))
    while members:
        size = math.ceil(len(members) / count)
        while _total(members[:size]) > _WIDTH - 2 * _MARGIN:
            size -= 1
        yield members[:size]
        members, count = members[size:], max(count - 1, 1)


def _total(row: list[str]) -> float:
    """How wide a row is."""
    return sum(_width(name) + _GAP for name in row) - _GAP


def _left(members: list[str], imported: Imports, placed: Mapping[str, Box], total: float) -> float:
    """The left edge of a row that is `total` wide: in the middle above what it imports, within the picture."""
    middle = sum(_centre(imported[name], placed) for name in members) / len(members)
    return min(max(middle - total / 2, _MARGIN), _WIDTH - _MARGIN - total)


def _centre(imported: frozenset[str], placed: Mapping[str, Box]) -> float:
    return math.fsum(placed[name].middle for name in imported) / len(imported) if imported else _WIDTH / 2


def _width(name: str) -> float:
    return len(name) * _CHARACTER + 16


def drawn(imported: Imports) -> str:
    """The picture."""
    placed, arrows = boxes(imported), reduced(imported)
    height = max(box.top for box in placed.values()) + _BOX + 60
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{_WIDTH}" height="{height:.0f}" '
            f'viewBox="0 0 {_WIDTH} {height:.0f}" font-family="monospace" font-size="12">',
            "<title>Packages of pytest-hricdv, each above what it imports</title>",
            f'<rect width="{_WIDTH}" height="{height:.0f}" fill="#ffffff"/>',
            '<g fill="none" stroke="#8a8a8a">',
            *(_arrow(placed[name], placed[lower]) for name in sorted(arrows) for lower in sorted(arrows[name])),
            "</g>",
            *(_drawn_box(placed[name]) for name in sorted(placed)),
            *_key(height - 34),
            "</svg>",
            "",
        ]
    )


def _arrow(upper: Box, lower: Box) -> str:
    start, end = upper.top + _BOX, lower.top
    bend = (end - start) / 2
    return (
        f'<path d="M{upper.middle:.0f} {start:.0f} C{upper.middle:.0f} {start + bend:.0f} '
        f'{lower.middle:.0f} {end - bend:.0f} {lower.middle:.0f} {end:.0f}"/>'
    )


def _drawn_box(box: Box) -> str:
    return (
        f'<rect x="{box.left:.0f}" y="{box.top:.0f}" width="{box.width:.0f}" height="{_BOX}" rx="4" '
        f'fill="{_FILLS[kind(box.name)]}" stroke="#555555"/>'
        f'<text x="{box.middle:.0f}" y="{box.top + 16:.0f}" text-anchor="middle">{escape(box.name)}</text>'
    )


def _key(top: float) -> Iterator[str]:
    left = float(_MARGIN)
    for group, text in _KEYS.items():
        yield f'<rect x="{left:.0f}" y="{top:.0f}" width="14" height="14" fill="{_FILLS[group]}" stroke="#555555"/>'
        yield f'<text x="{left + 20:.0f}" y="{top + 11:.0f}" font-size="11">{escape(text)}</text>'
        left += 20 + len(text) * 6.7 + 14


def main() -> int:
    """Draw the picture anew."""
    PICTURE.write_text(drawn(imports()), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
