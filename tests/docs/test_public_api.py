"""The public names: docs/public-api.md lists all of them and no others, and each has a docstring and a page."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest

from studies.site import public_names
from tests.docs.page import DOCS, blocks

ROOT = DOCS.parent
PUBLIC = public_names.listed()
PAGES = [*sorted(path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.md")), "../README.md"]
TO_COPY = [
    ROOT / "conftest.py",
    ROOT / "tests" / "hri" / "test_table_assembly.py",
    *sorted((ROOT / "sim").rglob("*.py")),
    *sorted((ROOT / "pytest_hricdv" / "skeleton" / "template").glob("*.py")),
]
"""What the documentation tells its readers to copy, or to look at for an example."""


@pytest.mark.parametrize("module", PUBLIC)
def test_the_list_is_what_the_module_says_is_public(module: str) -> None:
    assert sorted(PUBLIC[module]) == sorted(import_module(module).__all__)


def test_each_module_has_its_page() -> None:
    pages = public_names.pages()
    assert {f"api/{path.name}" for path in (DOCS / "api").glob("*.md")} == {*pages.values()}
    for module, page in pages.items():
        directives = re.findall(r"^\.\. automodule:: (\S+)$", (DOCS / page).read_text(encoding="utf-8"), re.MULTILINE)
        assert directives == [module]


@pytest.mark.parametrize("module", PUBLIC)
def test_each_name_and_each_method_has_a_docstring(module: str) -> None:
    assert [missing for name in PUBLIC[module] for missing in undocumented(module, name)] == []


@pytest.mark.parametrize("page", PAGES)
def test_a_page_imports_public_names_only(page: str) -> None:
    for block in blocks(page):
        if block.kind in ("python", "pycon"):
            assert private_imports(re.sub(r"^(>>>|\.\.\.) ?", "", block.text, flags=re.MULTILINE)) == []


@pytest.mark.parametrize("path", TO_COPY, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_what_users_copy_imports_public_names_only(path: Path) -> None:
    assert private_imports(path.read_text(encoding="utf-8")) == []


def test_a_private_import_is_noticed() -> None:
    assert private_imports("from pytest_hricdv.run import (\n    INSTANT_S,\n    Run,\n)") == [
        "pytest_hricdv.run.INSTANT_S"
    ]
    assert private_imports("    import pytest_hricdv.session.options") == ["pytest_hricdv.session.options"]


def private_imports(text: str) -> list[str]:
    """The names that Python text, or part of one, imports from the plugin although they are not public."""
    found = [module for module in re.findall(r"^ *import (pytest_hricdv[\w.]*)", text, re.M) if module not in PUBLIC]
    for module, in_brackets, in_line in re.findall(
        r"^ *from (pytest_hricdv[\w.]*) import (?:\(([^)]*)\)|(.*))$", text, re.MULTILINE
    ):
        names = re.findall(r"\w+", re.sub(r" as \w+|#.*", "", in_brackets or in_line))
        found += [f"{module}.{name}" for name in names if name not in PUBLIC.get(module, ())]
    return found


def undocumented(module: str, name: str) -> Iterator[str]:
    """What has no docstring: the name, or a public method or property of it if it is a class."""
    if not public_names.docstring(module, name):
        yield f"{module}.{name}"
    defining_module, (definition, *_) = public_names.home(module, name)
    for member in definition.body if isinstance(definition, ast.ClassDef) else ():
        if isinstance(member, ast.FunctionDef) and not member.name.startswith("_") and not ast.get_docstring(member):
            yield f"{defining_module}.{name}.{member.name}"
