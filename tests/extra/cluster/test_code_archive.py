"""The project as an archive."""

from __future__ import annotations

import io
import os
import shutil
import stat
import warnings
import zipfile
from pathlib import Path

import pytest

from pytest_hricdv.extra.cluster import code_archive
from pytest_hricdv.extra.cluster.address import ClusterError
from pytest_hricdv.extra.cluster.code_archive import ArchiveError


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A folder with code, and with what is no part of it."""
    for name in ("conftest.py", "robot/code.py", "models/a.asl", "robot/arm.urdf"):
        path = tmp_path / "project" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"# {name}\n", encoding="utf-8")
    for name in (".git/config", "venv/pyvenv.cfg", "venv/lib/a.py", "robot/__pycache__/code.pyc"):
        path = tmp_path / "project" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("no part of it", encoding="utf-8")
    return tmp_path / "project"


def names(folder: Path) -> set[str]:
    """Of all that is in a folder."""
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if not path.is_dir()}


def test_all_files_of_the_project_arrive_and_nothing_else(project: Path, tmp_path: Path) -> None:
    with code_archive.unpacked(code_archive.pack(project), tmp_path) as folder:
        assert names(folder) == {"conftest.py", "robot/code.py", "models/a.asl", "robot/arm.urdf"}
        assert (folder / "robot" / "code.py").read_text(encoding="utf-8") == "# robot/code.py\n"
    assert [path.name for path in tmp_path.iterdir()] == ["project"], "nothing is left"


def test_the_same_files_are_the_same_archive(project: Path) -> None:
    first = code_archive.pack(project)
    (project / "conftest.py").touch()
    assert code_archive.pack(project) == first
    (project / "conftest.py").write_text("# changed\n", encoding="utf-8")
    assert code_archive.digest(code_archive.pack(project)) != code_archive.digest(first)


def test_what_is_there_already_is_not_used(project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Folders of the name that an older release gave them, with another user's files, and links to them."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    archive = code_archive.pack(project)
    (tmp_path / "evil").mkdir()
    (tmp_path / "evil" / "conftest.py").write_text("raise SystemExit('evil')\n", encoding="utf-8")
    foreseen = f"hricdv-code-{os.getuid()}-{code_archive.digest(archive)[:16]}"
    shutil.copytree(tmp_path / "evil", tmp_path / foreseen)
    (tmp_path / "hricdv-code-").symlink_to(tmp_path / "evil")
    with code_archive.unpacked(archive) as first, code_archive.unpacked(archive) as second:
        for folder in (first, second):
            assert (folder / "conftest.py").read_text(encoding="utf-8") == "# conftest.py\n"
            assert stat.S_IMODE(folder.parent.stat().st_mode) == 0o700
            assert not folder.is_relative_to(tmp_path / foreseen)
        (first / "conftest.py").write_text("# changed by a run\n", encoding="utf-8")
        assert (second / "conftest.py").read_text(encoding="utf-8") == "# conftest.py\n"


def archive_of(*entries: zipfile.ZipInfo | str, data: bytes = b"text") -> bytes:
    """An archive that somebody else has made."""
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of names that are there twice
        for entry in entries:
            archive.writestr(entry, data)
    return made.getvalue()


def link(name: str) -> zipfile.ZipInfo:
    """An entry that is a symbolic link."""
    entry = zipfile.ZipInfo(name)
    entry.external_attr = (stat.S_IFLNK | 0o777) << 16
    return entry


@pytest.mark.parametrize(
    "entries",
    [
        ("../evil.py",),
        ("robot/../../evil.py",),
        ("/tmp/hricdv-evil.py",),
        ("//evil.py",),
        ("./../evil.py",),
        ("..",),
        (".",),
        ("folder/",),
        (link("conftest.py"),),
    ],
)
def test_files_elsewhere_and_links_are_refused(tmp_path: Path, entries: tuple[zipfile.ZipInfo | str, ...]) -> None:
    with (
        pytest.raises(ArchiveError, match=r"the project that was sent has '.*': expected files below its folder"),
        code_archive.unpacked(archive_of(*entries), tmp_path),
    ):
        pass
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("entries", [("a.py", "a.py"), ("a.py", "a.py/b.py"), ("a/b.py", "a")])
def test_no_file_takes_the_place_of_another_one(tmp_path: Path, entries: tuple[str, ...]) -> None:
    with pytest.raises(OSError, match="a"), code_archive.unpacked(archive_of(*entries), tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []


def test_an_archive_that_unpacks_to_more_than_a_project_has_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(code_archive, "MOST_BYTES", 1000)
    for archive in (archive_of("a", data=bytes(1001)), archive_of("a", "b", data=bytes(501))):
        with (
            pytest.raises(ArchiveError, match=r"has 1,00\d bytes, expected at most 1,000"),
            code_archive.unpacked(archive, tmp_path),
        ):
            pass


def test_more_than_an_entry_declares_is_not_unpacked(tmp_path: Path) -> None:
    whole = archive_of("a", data=b"x" * 5000)
    forged = whole.replace((5000).to_bytes(4, "little"), (10).to_bytes(4, "little"))
    with pytest.raises(ArchiveError, match="is damaged"), code_archive.unpacked(forged, tmp_path):
        pass


@pytest.mark.parametrize("share", [0.0, 0.3, 0.6, 0.95])
def test_an_archive_that_is_damaged_is_refused(project: Path, tmp_path: Path, share: float) -> None:
    whole = code_archive.pack(project)
    with (
        pytest.raises(ArchiveError, match="the project that was sent is damaged"),
        code_archive.unpacked(whole[: int(share * len(whole))], tmp_path),
    ):
        pass


def test_results_are_no_part_of_a_project(project: Path) -> None:
    before = code_archive.pack(project, project / "campaign.db")
    for name in (
        "campaign.db",
        "campaign.db-wal",
        "campaign.db.lock",
        "hri-report/report.json",
        "hri-report/films/a.mp4",
    ):
        path = project / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"results")
    assert code_archive.pack(project, project / "campaign.db") == before
    (project / "more.db").write_bytes(b"data of the project")
    assert code_archive.pack(project, project / "campaign.db") != before


def test_a_project_with_data_is_not_sent(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(code_archive, "MOST_BYTES", 1000)
    (project / "recordings.bin").write_bytes(bytes(1001))
    with pytest.raises(ClusterError, match=r"more than 1,000 bytes, .* install the project where the workers are"):
        code_archive.pack(project)
