from __future__ import annotations

import os
from pathlib import Path

import pytest

from pytest_hricdv.__main__ import main
from pytest_hricdv.extra.draft.project.answers import merge
from tests.extra.draft import robots

DRAFTED = "low = 1  # robot.py:3\nhigh = 2  # robot.py:4\nlast = 3\n"


@pytest.mark.parametrize(
    ("now", "new", "merged"),
    [
        pytest.param(DRAFTED, "other = 1\n", "other = 1\n", id="nobody changed anything"),
        pytest.param(
            DRAFTED.replace("2", "5"),
            "low = 1  # robot.py:8\nhigh = 2  # robot.py:9\nlast = 3\nmore = 4\n",
            "low = 1  # robot.py:8\nhigh = 5  # robot.py:4\nlast = 3\nmore = 4\n",
            id="the code has moved, and has more",
        ),
        pytest.param(
            DRAFTED.replace("2", "5"), DRAFTED.replace("2", "7"), DRAFTED.replace("2", "5"), id="both changed a line"
        ),
        pytest.param("low = 1\nlast = 3\n", DRAFTED + "new\n", "low = 1\nlast = 3\nnew\n", id="a line is gone"),
        pytest.param(DRAFTED + "own = 9\n", DRAFTED, DRAFTED + "own = 9\n", id="a line was added"),
    ],
)
def test_what_somebody_changed_stays(now: str, new: str, merged: str) -> None:
    assert merge(DRAFTED, now, new) == merged


def edit(file: Path, old: str, new: str) -> None:
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new), encoding="utf-8")


def test_a_draft_that_is_repeated_keeps_answers_and_has_what_the_code_has_now(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    code, hri = tmp_path / "robot_code.py", tmp_path / "hri"
    code.write_text(robots.MATCH, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    command = ["init", "hri", "--from", "robot_code", "--no-run"]
    assert main(command) == 0
    before = {path.name: path.read_bytes() for path in hri.rglob("*") if path.is_file()}
    assert main(command) == 0
    assert {path.name: path.read_bytes() for path in hri.rglob("*") if path.is_file()} == before
    edit(hri / "conftest.py", "LIMIT_S = 900.0", "LIMIT_S = 300.0")
    requirements = (hri / "requirements.toml").read_text(encoding="utf-8")
    begin, end = requirements.index("[R2]"), requirements.index("[R3]")
    (hri / "requirements.toml").write_text(requirements[:begin] + requirements[end:] + OWN, encoding="utf-8")
    code.write_text("SETTLES_S = 2.0\n" + robots.MATCH.replace('"fetch"', '"carry"'), encoding="utf-8")
    capsys.readouterr()
    assert main(command) == 0
    assert "what was changed since stays as it is, in conftest.py, requirements.toml" in capsys.readouterr().out
    conftest = (hri / "conftest.py").read_text(encoding="utf-8")
    assert "LIMIT_S = 300.0" in conftest
    assert 'kind="carry"' in conftest
    repeated = (hri / "requirements.toml").read_text(encoding="utf-8")
    assert repeated.endswith(OWN)
    assert "[R2]" not in repeated


OWN = '\n[quiet]\ntitle = "Mine"\nformula = "always(person_is_there -> robot_works)"\n'


def test_a_file_of_no_draft_is_not_overwritten_where_there_is_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "robot_code.py").write_text(robots.MATCH, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    command = ["init", "hri", "--from", "robot_code", "--no-run"]
    assert main(command) == 0
    (record,) = [path for path in os.listdir("hri") if path.startswith(".")]
    (tmp_path / "hri" / record).unlink()
    assert main(command) == 2
    assert "conftest.py exists: nothing was written" in capsys.readouterr().err
