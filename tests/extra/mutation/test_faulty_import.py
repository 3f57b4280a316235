"""A module is imported with another text, wherever it lies, and nothing else is."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from pytest_hricdv.execution.faulty_import import FaultyImport


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A package of two modules, importable and imported by no one."""
    folder = tmp_path / "faulty_package"
    folder.mkdir()
    (folder / "__init__.py").write_text("WHO = 'package'\n", encoding="utf-8")
    (folder / "one.py").write_text("from faulty_package import two\nWHO = 'one and ' + two.WHO\n", encoding="utf-8")
    (folder / "two.py").write_text("WHO = 'two'\n", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    yield folder
    for name in [name for name in sys.modules if name.startswith("faulty_package")]:
        del sys.modules[name]


@pytest.mark.parametrize(
    ("file", "expected"),
    [
        ("__init__.py", ("other", "one and two")),
        ("one.py", ("package", "other")),
        ("two.py", ("package", "one and other")),
    ],
)
def test_a_file_is_imported_with_another_text(
    package: Path, file: str, expected: tuple[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    before = (package / file).read_text(encoding="utf-8")
    finder = FaultyImport({package / file: "WHO = 'other'\n"})
    monkeypatch.setattr(sys, "meta_path", [finder, *sys.meta_path])
    one = importlib.import_module("faulty_package.one")
    found = importlib.import_module("faulty_package").WHO, one.WHO
    assert found == expected
    assert (package / file).read_text(encoding="utf-8") == before


def test_the_code_of_a_cached_file_is_not_used(package: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert importlib.import_module("faulty_package.two").WHO == "two"
    del sys.modules["faulty_package.two"]
    monkeypatch.setattr(sys, "meta_path", [FaultyImport({package / "two.py": "WHO = 'other'\n"}), *sys.meta_path])
    assert importlib.import_module("faulty_package.two").WHO == "other"
    del sys.modules["faulty_package.two"]
    sys.meta_path.pop(0)
    assert importlib.import_module("faulty_package.two").WHO == "two"
