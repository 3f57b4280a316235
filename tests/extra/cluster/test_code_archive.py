"""The project as an archive."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.extra.cluster import code_archive
from pytest_hricdv.extra.cluster.address import ClusterError


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


def test_all_files_of_the_project_arrive_and_nothing_else(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(project.parent))
    folder = code_archive.unpacked(code_archive.pack(project))
    found = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert found == {"conftest.py", "robot/code.py", "models/a.asl", "robot/arm.urdf"}
    assert (folder / "robot" / "code.py").read_text(encoding="utf-8") == "# robot/code.py\n"


def test_the_same_files_are_the_same_archive_in_the_same_folder(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(project.parent))
    first = code_archive.pack(project)
    (project / "conftest.py").touch()
    assert code_archive.pack(project) == first
    assert code_archive.unpacked(first) == code_archive.unpacked(first)
    (project / "conftest.py").write_text("# changed\n", encoding="utf-8")
    assert code_archive.unpacked(code_archive.pack(project)) != code_archive.unpacked(first)


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
