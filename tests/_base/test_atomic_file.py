"""Files are written whole or not at all."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv._base.atomic_file import write_bytes, write_text


def test_the_folder_is_made_and_nothing_else_is_left_in_it(tmp_path: Path) -> None:
    path = write_text(tmp_path / "a" / "b.txt", "leg")
    assert path.read_text() == "leg"
    assert [each.name for each in path.parent.iterdir()] == ["b.txt"]


def test_an_old_file_is_replaced(tmp_path: Path) -> None:
    path = write_text(tmp_path / "b.txt", "old and long")
    assert write_bytes(path, b"new").read_bytes() == b"new"


def test_a_lone_surrogate_is_written_as_its_escape(tmp_path: Path) -> None:
    assert write_text(tmp_path / "b.txt", "leg\udce9").read_text() == "leg\\udce9"


def test_what_cannot_be_written_leaves_the_folder_as_it_was(tmp_path: Path) -> None:
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "inside").touch()
    with pytest.raises(OSError, match="taken"):
        write_text(tmp_path / "taken", "leg")
    assert [each.name for each in tmp_path.iterdir()] == ["taken"]
