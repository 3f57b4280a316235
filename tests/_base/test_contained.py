"""Files in a folder of somebody else: no link in it is followed, and no name leads out."""

from __future__ import annotations

import zlib
from pathlib import Path

import pytest

from pytest_hricdv._base.contained import file_inside, files_inside, inside
from pytest_hricdv._base.input_file import MalformedError, unpack


@pytest.mark.parametrize("name", ["../a", "a/../../b", "/etc/passwd", "", ".", "a/.."])
def test_no_name_leads_out(tmp_path: Path, name: str) -> None:
    with pytest.raises(OSError, match="leads out of its folder"):
        inside(tmp_path, name)


def test_a_link_is_refused_wherever_it_stands(tmp_path: Path) -> None:
    folder, victim = tmp_path / "report", tmp_path / "victim"
    folder.mkdir()
    victim.mkdir()
    (victim / "secret.json").write_text("{}")
    (folder / "failures").symlink_to(victim)
    (folder / "link.json").symlink_to(victim / "secret.json")
    (folder / "nowhere").symlink_to(tmp_path / "nothing")
    for name in ("failures/secret.json", "failures/new.json", "nowhere/a"):
        with pytest.raises(OSError, match="a symbolic link, which is not followed here"):
            inside(folder, name)
    for name in ("link.json", "nowhere"):
        assert inside(folder, name) == folder / name, "a rename replaces it"
        with pytest.raises(OSError, match="a symbolic link"):
            file_inside(folder, name)
    with pytest.raises(OSError, match="a symbolic link"):
        list(files_inside(folder, "failures", (".json",)))


def test_the_folder_itself_is_the_users_choice(tmp_path: Path) -> None:
    (tmp_path / "real" / "failures").mkdir(parents=True)
    (tmp_path / "real" / "failures" / "a.json").write_text("{}")
    (tmp_path / "real" / "failures" / "a.html").write_text("<script>")
    (tmp_path / "latest").symlink_to(tmp_path / "real")
    assert [path.name for path in files_inside(tmp_path / "latest", "failures", (".json",))] == ["a.json"]
    assert list(files_inside(tmp_path / "latest", "films", (".mp4",))) == []


def test_unpacking_is_bounded() -> None:
    assert unpack(zlib.compress(b"abc")) == b"abc"
    assert unpack(zlib.compress(b"abc"), 3) == b"abc"
    for data, reason in (
        (zlib.compress(b"abcd"), "unpacks to too much"),
        (zlib.compress(b"abc")[:-1], "truncated"),
        (zlib.compress(b"abc") + b"x", "trailing data"),
        (b"", "truncated"),
        (b"abc", "cannot be unpacked"),
    ):
        with pytest.raises(MalformedError, match=reason):
            unpack(data, 3)
