"""Where a report comes from."""

from __future__ import annotations

import datetime
import subprocess

import pytest

from tests.plugin.project import command, report

SUITE = ("--hri-suite=by-hand", "-p", "no:xdist")


def git(lamps: pytest.Pytester, *arguments: str) -> str:
    identity = ("-c", "user.name=nobody", "-c", "user.email=nobody@example.org")
    done = subprocess.run(["git", *identity, *arguments], cwd=lamps.path, capture_output=True, text=True, check=True)
    return done.stdout.strip()


@pytest.mark.slow
def test_a_report_names_its_revision_command_and_versions(lamps: pytest.Pytester) -> None:
    git(lamps, "init", "--quiet")
    git(lamps, "add", "lamps", "conftest.py")
    git(lamps, "commit", "--quiet", "-m", "begun")
    lamps.runpytest_inprocess(*SUITE)
    origin = report(lamps.path)["origin"]
    assert origin["revision"] == git(lamps, "rev-parse", "HEAD")
    assert "dirty" not in origin
    assert origin["command"][: len(SUITE)] == list(SUITE) or set(SUITE) <= set(origin["command"])
    assert (origin["ini"], origin["versions"]["pytest"]) == ("pytest.ini", pytest.__version__)
    age = datetime.datetime.now(datetime.UTC) - datetime.datetime.fromisoformat(origin["began"])
    assert datetime.timedelta(0) <= age < datetime.timedelta(minutes=5)
    with (lamps.path / "lamps" / "guide.py").open("a", encoding="utf-8") as file:
        file.write("# changed\n")
    lamps.runpytest_inprocess(*SUITE)
    assert report(lamps.path)["origin"]["dirty"]
    page = (lamps.path / "hri-report" / "index.html").read_text(encoding="utf-8")
    assert origin["revision"][:12] in page
    assert "with local changes" in page


@pytest.mark.slow
def test_a_merged_report_has_those_of_its_sessions(lamps: pytest.Pytester) -> None:
    for shard in ("1/2", "2/2"):
        lamps.runpytest_inprocess(*SUITE, f"--hri-shard={shard}", f"--hri-report=part{shard[0]}")
    merged = command("merge", "part1", "part2", "-o", "hri-report")
    assert merged.returncode == 0, merged.stderr
    found = report(lamps.path)
    assert "origin" not in found
    commands = sorted(" ".join(session["origin"]["command"]) for session in found["sessions"])
    assert ["--hri-shard=1/2" in commands[0], "--hri-shard=2/2" in commands[1]] == [True, True]


def test_without_a_repository_there_is_no_revision(lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(lamps.path.parent))
    lamps.runpytest_inprocess(*SUITE)
    assert "revision" not in report(lamps.path)["origin"]
