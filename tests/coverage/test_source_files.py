"""Which files the code under test has: those that Python would import, found without importing any."""

from __future__ import annotations

import py_compile
import sys
from pathlib import Path

import pytest

from pytest_hricdv.coverage.code_map import CodeMap, map_code
from pytest_hricdv.coverage.source_files import find_without_importing


def write(folder: Path, files: dict[str, str]) -> None:
    """Write the files of a project."""
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def names(code: CodeMap) -> list[str]:
    """The names of the files that are measured."""
    return [file.name for file in code.files]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder in which modules are found."""
    monkeypatch.syspath_prepend(str(tmp_path))
    return tmp_path


def test_a_folder_without_init_is_a_namespace_package(folder: Path) -> None:
    write(folder, {"spaced/__init__.py": "", "spaced/parts/arm.py": "x = 1\n", "spaced/parts/in/hand.py": "y = 1\n"})
    write(folder, {"spaced/not-a-name/tool.py": "z = 1\n", "spaced/__pycache__/old.py": "z = 1\n"})
    assert names(map_code(["spaced"], folder)) == [
        "spaced/__init__.py",
        "spaced/parts/arm.py",
        "spaced/parts/in/hand.py",
    ]


def test_a_namespace_package_has_the_files_of_all_its_portions(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for number, portion in enumerate(("one", "two")):
        write(folder / portion, {f"portioned/part{number}.py": "x = 1\n"})
        monkeypatch.syspath_prepend(str(folder / portion))
    code = map_code(["portioned"], folder)
    assert names(code) == ["one/portioned/part0.py", "two/portioned/part1.py"]
    assert map_code(["portioned.part1"], folder).files[0].name == "two/portioned/part1.py"


def test_nothing_is_imported_to_find_a_module_of_a_package(folder: Path) -> None:
    write(folder, {"moving/__init__.py": "raise SystemExit('the arm moves')\n", "moving/parts/arm.py": "x = 1\n"})
    assert names(map_code(["moving.parts.arm"], folder)) == ["moving/parts/arm.py"]
    assert find_without_importing("moving.parts.leg") is None
    assert find_without_importing("moving..arm") is None
    assert "moving" not in sys.modules


@pytest.mark.parametrize(
    ("data", "text"),
    [
        (b'\xef\xbb\xbfx = "\xc3\xa9"\n', 'x = "é"\n'),
        (b'# -*- coding: latin-1 -*-\nx = "\xe9"\n', '# -*- coding: latin-1 -*-\nx = "é"\n'),
        (b'#!/usr/bin/python\n# vim: set fileencoding=cp1252 :\nx = "\x80"\n', "€"),
        (b"x = 1\r\nif x:\r\n    y = 2\r\n", "x = 1\nif x:\n    y = 2\n"),
        (b"x = 1\x0c\ny = 2", "x = 1 \ny = 2\n"),
    ],
    ids=["BOM", "latin-1", "cp1252 in the second line", "CRLF", "form feed and no end"],
)
def test_sources_are_read_as_python_reads_them(folder: Path, data: bytes, text: str) -> None:
    (folder / "encoded.py").write_bytes(data)
    (file,) = map_code(["encoded"], folder).files
    assert text in file.text
    assert file.statements


def test_a_module_without_source_is_unmeasured_with_the_reason(folder: Path) -> None:
    write(folder, {"closed/__init__.py": "x = 1\n", "closed/secret.py": "y = 1\n"})
    py_compile.compile(str(folder / "closed" / "secret.py"), cfile=str(folder / "closed" / "secret.pyc"))
    (folder / "closed" / "secret.py").unlink()
    (folder / "closed" / "fast.so").write_bytes(b"\x7fELF")
    code = map_code(["closed"], folder)
    assert names(code) == ["closed/__init__.py"]
    assert code.unmeasured == {
        "closed/fast.so": "it is an extension module, and has no source in Python",
        "closed/secret.pyc": "it has no source: only the compiled file is there",
    }
    assert {*code.contents} == {"closed/__init__.py", "closed/fast.so", "closed/secret.pyc"}


def test_code_of_which_there_is_no_source_at_all_is_unmeasured(folder: Path) -> None:
    (folder / "quick.so").write_bytes(b"\x7fELF")
    code = map_code(["quick"], folder)
    assert code.nothing == "code under test, quick: it has no Python source"
