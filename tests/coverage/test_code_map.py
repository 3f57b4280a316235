"""The code map: statements, branches, waivers, bits."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.coverage.code_map import Bits, CodeMap, CoverageError, map_code
from tests.coverage.project import SOURCE, write_package


@pytest.fixture
def code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> CodeMap:
    write_package(tmp_path, "graded")
    monkeypatch.syspath_prepend(str(tmp_path))
    return map_code(["graded"], tmp_path)


def test_statements_branches_and_waivers_are_found_without_importing(code: CodeMap) -> None:
    (file,) = code.files
    assert file.name == "graded/__init__.py"
    assert file.statements == (3, 6, 7, 8, 9, 10, 11, 14, 15)
    assert file.branches == ((7, 8), (7, 9), (9, 10), (9, 11))
    assert [(w.line, w.reason) for w in code.waivers] == [(15, "never called")]


def test_the_hash_changes_with_the_code_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = write_package(tmp_path, "hashed")
    monkeypatch.syspath_prepend(str(tmp_path))
    before = map_code(["hashed"], tmp_path).sha256
    assert map_code(["hashed"], tmp_path).sha256 == before
    file.write_text(SOURCE.replace("LIMIT = 3", "LIMIT = 4"), encoding="utf-8")
    assert map_code(["hashed"], tmp_path).sha256 != before


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("x = 1  # unreachable:\n", "waived/__init__.py:1: a waiver needs its reason"),
        ("x = 1  # unreachable:  \n", "waived/__init__.py:1: a waiver needs its reason"),
        ("x = 1\n# unreachable: stands alone\n", "waived/__init__.py:2: no statement is on the line of this waiver"),
        ("def f(:\n", "code under test"),
    ],
)
def test_what_cannot_be_mapped_is_refused_with_its_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, source: str, message: str
) -> None:
    write_package(tmp_path, "waived", source)
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(CoverageError, match=message):
        map_code(["waived"], tmp_path)


def test_prose_that_begins_with_the_word_is_no_waiver(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Comments of code that was written for something else."""
    write_package(tmp_path, "prose", "# where it is\n# unreachable, keep it\nx = 1  # unreachable in summer\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert map_code(["prose"], tmp_path).files[0].waivers == ()


def test_a_package_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(CoverageError, match="no package or module 'no_such_package'"):
        map_code(["no_such_package"], tmp_path)


bitsets = st.builds(Bits, st.integers(0, 2**40), st.one_of(st.none(), st.integers(0, 2**20)))


@given(bitsets, bitsets, bitsets)
def test_merging_bits_does_not_depend_on_order_or_grouping(a: Bits, b: Bits, c: Bits) -> None:
    assert a | b == b | a
    assert (a | b) | c == a | (b | c)
    assert a | a == a
