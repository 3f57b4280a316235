"""The project as an archive."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import pytest

from pytest_hricdv._base import project_files
from pytest_hricdv.extra.cluster import code_archive
from pytest_hricdv.extra.cluster.code_archive import worker_project
from pytest_hricdv.session.remote import ClusterError


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


def packed(project: Path, state: Path | None = None, hidden: tuple[str, ...] = ()) -> bytes:
    """The project as it is sent."""
    return code_archive.pack(project, code_archive.files_to_send(project, state, hidden))


def names(folder: Path) -> set[str]:
    """Of all that is in a folder."""
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if not path.is_dir()}


def test_all_files_of_the_project_arrive_and_nothing_else(project: Path, tmp_path: Path) -> None:
    with code_archive.unpack(packed(project), tmp_path) as folder:
        assert names(folder) == {"conftest.py", "robot/code.py", "models/a.asl", "robot/arm.urdf"}
        assert (folder / "robot" / "code.py").read_text(encoding="utf-8") == "# robot/code.py\n"
    assert [path.name for path in tmp_path.iterdir()] == ["project"], "nothing is left"


def test_results_are_no_part_of_a_project(project: Path) -> None:
    before = packed(project, project / "campaign.db")
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
    assert packed(project, project / "campaign.db") == before
    (project / "more.db").write_bytes(b"data of the project")
    assert packed(project, project / "campaign.db") != before


HIDDEN = (".env", ".netrc", "robot/.secrets.toml", "robot/.a.py", ".pytest.ini", "robot/.pytest.ini")


@pytest.mark.parametrize(
    ("hidden", "arriving"),
    [
        ((), {".pytest.ini"}),
        ((".env",), {".pytest.ini", ".env"}),
        (("robot/.*",), {".pytest.ini", "robot/.secrets.toml", "robot/.a.py", "robot/.pytest.ini"}),
        ((".*.toml", ".a.py"), {".pytest.ini", "robot/.secrets.toml", "robot/.a.py"}),
    ],
)
def test_hidden_files_are_sent_only_where_they_are_named(
    project: Path, hidden: tuple[str, ...], arriving: set[str]
) -> None:
    before = {path.relative_to(project).as_posix() for path in code_archive.files_to_send(project)}
    for name in HIDDEN:
        (project / name).write_text("# secret\n", encoding="utf-8")
    made = worker_project(project, project, send=True, hidden=hidden)
    with zipfile.ZipFile(io.BytesIO(made.archive)) as archive:
        assert {*archive.namelist()} == before | arriving
    there = made.service("m", b"", project_files.hashes(project), 1.0)
    with code_archive.unpack(made.archive) as folder:
        assert there.project == there.sources == project_files.hashes(folder)


@pytest.mark.parametrize(
    "target",
    [
        "/etc/passwd",
        "../beside.txt",
        "chain",
        ".env",
        ".git/config",
        "venv/lib/a.py",
        "hri-report/report.json",
        "campaign.db",
        "../project/.env",
        "robot/../../beside.txt",
    ],
)
def test_a_link_to_what_is_not_sent_is_refused_with_its_name(project: Path, target: str) -> None:
    (project.parent / "beside.txt").write_text("somebody's\n", encoding="utf-8")
    for name in (".env", "campaign.db", "hri-report/report.json"):
        (project / name).parent.mkdir(exist_ok=True)
        (project / name).write_text("KEY=1\n", encoding="utf-8")
    (project / ".hidden").mkdir()
    if target == "chain":
        (project / ".hidden" / "chain").symlink_to(project.parent / "beside.txt")
        target = ".hidden/chain"
    (project / "robot" / "data.txt").symlink_to(project / target)
    with pytest.raises(ClusterError, match=r"'robot/data.txt' in .* is a symbolic link to .*, which is not sent: put"):
        code_archive.files_to_send(project, project / "campaign.db")


def test_links_within_the_project_arrive_as_files(project: Path, tmp_path: Path) -> None:
    (project / "first.urdf").symlink_to(project / "robot" / "arm.urdf")
    (project / "second.urdf").symlink_to("first.urdf")
    (project / "same").symlink_to("robot")
    (project / "gone").symlink_to("nowhere")
    with code_archive.unpack(packed(project), tmp_path) as folder:
        assert names(folder) >= {"first.urdf", "second.urdf", "robot/arm.urdf"}
        assert not names(folder) & {"same", "gone", "same/arm.urdf"}
        assert not any(path.is_symlink() for path in folder.rglob("*"))


def test_a_link_to_a_folder_elsewhere_is_refused(project: Path, tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (project / "robot" / "data").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(
        ClusterError, match=r"'robot/data' in .*elsewhere', which is not sent: put a copy of the folder"
    ):
        code_archive.files_to_send(project)
    (project / ".links").mkdir()
    (project / "robot" / "data").rename(project / ".links" / "data")
    assert code_archive.files_to_send(project)
