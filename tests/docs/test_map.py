"""What pages and docstrings of packages name in the code exists; the map of the code has ten behaviours."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from tests.docs.page import DOCS

SECTION = "## Map of the code"
PLACE = re.compile(r"`([\w/]+\.py): ([\w.]+)`")
ITEM = re.compile(r"^- (`\w+`(?:, `\w+`)*):", re.MULTILINE)
PACKAGES = sorted((DOCS.parent / "pytest_hricdv").rglob("__init__.py"))


def places() -> list[tuple[str, str, str]]:
    """Each place that a page names: the page, the file, and the name in it."""
    pages = sorted([*DOCS.glob("*.md"), *DOCS.parent.glob("*.md")])
    return [(page.name, *place) for page in pages for place in PLACE.findall(page.read_text(encoding="utf-8"))]


def defined(file: Path) -> set[str]:
    """The functions, classes, methods and constants of a module, methods as `Class.method`."""

    def names(nodes: list[ast.stmt], prefix: str) -> set[str]:
        found = set()
        for node in nodes:
            if isinstance(node, ast.ClassDef | ast.FunctionDef):
                found.add(prefix + node.name)
            if isinstance(node, ast.Assign):
                found |= {prefix + target.id for target in node.targets if isinstance(target, ast.Name)}
            if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
                found.add(prefix + node.target.id)
            if isinstance(node, ast.ClassDef):
                found |= names(node.body, f"{prefix}{node.name}.")
        return found

    return names(ast.parse(file.read_text(encoding="utf-8")).body, "")


def test_the_map_has_ten_behaviours() -> None:
    rows = (DOCS / "how-it-works.md").read_text(encoding="utf-8").partition(f"{SECTION}\n")[2].partition("\n## ")[0]
    assert sum(bool(PLACE.search(line)) for line in rows.splitlines()) == 10


@pytest.mark.parametrize(("page", "file", "name"), places(), ids=lambda part: part.rpartition("/")[2])
def test_each_place_that_a_page_names_exists(page: str, file: str, name: str) -> None:
    path = DOCS.parent / file
    assert path.is_file(), f"{page} names {file}, which does not exist"
    assert name in defined(path), f"{page} names {name}, which {file} does not define"


@pytest.mark.parametrize("package", PACKAGES, ids=lambda path: path.parent.name)
def test_the_modules_that_a_package_lists_exist(package: Path) -> None:
    listed = {name for item in ITEM.findall(package.read_text(encoding="utf-8")) for name in re.findall(r"\w+", item)}
    assert not listed - {path.stem for path in package.parent.iterdir()}
