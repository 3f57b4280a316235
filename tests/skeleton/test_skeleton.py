"""`hricdv init`: what it writes runs, and is as clean as it should be."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.__main__ import main
from pytest_hricdv.skeleton.skeleton import Skeleton, SkeletonError, name_like


def run(folder: Path, *module: str) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PYTEST_ADDOPTS": ""}
    command = [sys.executable, "-m", *module]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300)


@pytest.mark.slow
def test_it_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "Kitchen-Robot"
    assert main(["init", str(folder)]) == 0
    said = capsys.readouterr().out.splitlines()
    assert f"now:  cd {folder}; pytest" in said
    assert f"{folder / 'kitchen_robot.py'}" in said
    note, found = run(folder, "pytest_hricdv.bdi", "lint", "models/kitchen_robot.mas2j").stderr.splitlines()
    assert note.startswith("note: external actions ask, come_near, go_away, wait_done:")
    assert found == "nothing found"
    done = run(folder, "pytest", "-p", "no:cacheprovider")
    assert done.returncode == 0, done.stdout
    report = json.loads((folder / "hri-report" / "report.json").read_text(encoding="utf-8"))
    assert report["testbench"] == "kitchen_robot"
    assert report["selected"] == report["reported"] > 3
    (suite,) = report["suites"]
    assert all(each["passed"] and each["triggers"] and not each["failed"] for each in suite["requirements"].values())
    assert suite["code"]["statements"]["percent"] == 100.0


def test_several_people_have_a_model_each(tmp_path: Path) -> None:
    assert main(["init", str(tmp_path), "--robot=arm7", "--people=nurse,child,cook"]) == 0
    models = {path.name: path.read_text(encoding="utf-8") for path in (tmp_path / "models").iterdir()}
    assert models.keys() == {"meta.asl", "nurse.asl", "child.asl", "cook.asl", "arm7.mas2j"}
    assert "MAS arm7 { agents: meta; nurse; child; cook; }" in models["arm7.mas2j"]
    assert 'PEOPLE = ("nurse", "child", "cook")' in (tmp_path / "conftest.py").read_text(encoding="utf-8")
    assert not [path for path in tmp_path.rglob("*") if path.is_file() and "my_" in path.read_text(encoding="utf-8")]


@pytest.mark.slow
def test_several_people_run(tmp_path: Path) -> None:
    main(["init", str(tmp_path), "--robot=arm", "--people=nurse,child"])
    assert run(tmp_path, "pytest_hricdv.bdi", "lint", "models/arm.mas2j").stderr.endswith("nothing found\n")
    for check in (["ruff", "check", "--isolated", "."], ["mypy", "--strict", "conftest.py"]):
        done = run(tmp_path, *check)
        assert done.returncode == 0, done.stdout
    done = run(tmp_path, "pytest", "-p", "no:cacheprovider", "--hri-tests=6", "--hri-audit=off")
    assert done.returncode == 0, done.stdout
    report = json.loads((tmp_path / "hri-report" / "report.json").read_text(encoding="utf-8"))
    assert all({line.partition(":")[0] for line in test["abstract"]} == {"nurse", "child"} for test in report["tests"])


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("--robot=My-Arm", "--robot=My-Arm: expected a name of small letters, digits and underscores that begins with"),
        ("--person=Ann", "such as ann"),
        ("--robot=world", "--robot=world: a file of the skeleton has this name; choose another one"),
        ("--robot=person", "--robot and --person: both are person; expected two names"),
        ("--people=nurse,person,Ann", "--people=Ann: expected a name of small letters"),
        ("--people=nurse,nurse", "--people=nurse,nurse: expected each name once"),
        ("--robot=class", "--robot=class: expected a name of small letters"),
    ],
)
def test_names_that_cannot_be(tmp_path: Path, capsys: pytest.CaptureFixture[str], given: str, said: str) -> None:
    assert main(["init", str(tmp_path), given]) == 2
    assert said in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    assert main(["init", str(tmp_path / "file" / "inside")]) == 2
    assert "inside: cannot be written: Not a directory" in capsys.readouterr().err


@given(st.text())
def test_any_folder_gives_a_name(text: str) -> None:
    try:
        assert Skeleton(name_like(text), "nobody").robot == name_like(text)
    except SkeletonError:
        assert name_like(text) == "nobody"
