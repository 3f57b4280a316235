"""The workflow of docs/continuous-integration.md does what the page says, job by job."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import venv
from pathlib import Path

import pytest

from tests.docs.page import DOCS, blocks
from tests.plugin import project

ROOT = DOCS.parent
PAGE = "continuous-integration.md"
PER_TEST = ("PYTEST_", "COV_", "PYTHON", "VIRTUAL_ENV")
"""Beginnings of environment variables that belong to the session of this test, and not to a CI job."""

INSTALL_S, RUN_S = 600, 600


def workflow() -> str:
    """The text of the workflow file."""
    (found,) = [block.text for block in blocks(PAGE) if block.kind == "yaml"]
    return found


def steps(job: str) -> list[str]:
    """The commands of a job, in order, once for each of its shards where they name one."""
    _, _, jobs = workflow().partition("\njobs:\n")
    parts = re.split(r"^  (\w+):\n", jobs, flags=re.MULTILINE)
    text = dict(zip(parts[1::2], parts[2::2], strict=True))[job]
    shards = re.search(r"shard: \[(.*)\]", text)
    found = []
    for command in re.findall(r"^ +- run: (.*)$", text, re.MULTILINE):
        each = shards[1].split(", ") if shards and "matrix.shard" in command else [""]
        found += [command.replace("${{ matrix.shard }}", shard) for shard in each]
    return found


def run(command: str, folder: Path, programs: Path, summary: Path, timeout_s: int = RUN_S) -> str:
    """Run a command as a CI job does; returns what it printed."""
    clean = {name: value for name, value in os.environ.items() if not name.startswith(PER_TEST)}
    path = os.pathsep.join([str(programs), os.environ["PATH"]])
    github = {"GITHUB_ACTIONS": "true", "GITHUB_STEP_SUMMARY": str(summary)}
    done = subprocess.run(
        ["bash", "-c", command],
        cwd=folder,
        env=clean | {"PATH": path} | github,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=timeout_s,
        check=False,
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}"
    return done.stdout


def environment(folder: Path) -> Path:
    """A fresh virtual environment; returns the folder of its programs."""
    venv.create(folder, with_pip=True, symlinks=True)
    return folder / "bin"


def checkout(folder: Path) -> Path:
    """A copy of this checkout, as git would clone it, with what is not committed yet."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    for name in filter(None, listed.stdout.split("\0")):
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)
    return folder


@pytest.mark.slow
def test_shards_are_run_and_merged_in_a_project(tmp_path: Path) -> None:
    project.write(tmp_path)
    summary, programs = tmp_path / "job.md", Path(sys.executable).parent
    _, *shards = steps("run")
    _, merge, export = steps("merge")
    assert len(shards) == 3
    for shard in shards:
        run(shard.replace("-n 2", ""), tmp_path, programs, summary)
    assert "34/34 tests merged" in run(merge, tmp_path, programs, summary)
    run(export, tmp_path, programs, summary)
    report = json.loads((tmp_path / "hri-report" / "report.json").read_text(encoding="utf-8"))
    assert report["reported"] == 34
    assert {path.name for path in (tmp_path / "hri-report").iterdir()} >= {"index.html", "cobertura.xml", "lcov.info"}
    assert summary.read_text(encoding="utf-8").count("## Human-robot interaction: lamps, passed") == 4
    assert (tmp_path / "hri-report-2" / "junit.xml").exists()


@pytest.mark.slow
def test_the_workflow_runs_in_fresh_environments(tmp_path: Path) -> None:
    """With only what the workflow installs, not with what this project is developed with; here with fewer tests."""
    folder, summary = checkout(tmp_path / "checkout"), tmp_path / "job.md"
    programs = environment(tmp_path / "run")
    install, *shards = steps("run")
    assert install == 'pip install -e ".[sim]"'
    run(install, folder, programs, summary, INSTALL_S)
    installed = run("pip list", folder, programs, summary)
    assert "hypothesis" not in installed
    for shard in shards:
        run(f"{shard} --hri-tests=24 --hri-audit=off", folder, programs, summary)
    programs = environment(tmp_path / "merge")
    install, merge, export = steps("merge")
    assert install == "pip install -e ."
    run(install, folder, programs, summary, INSTALL_S)
    assert "pybullet" not in run("pip list", folder, programs, summary)
    assert "24/24 tests merged" in run(merge, folder, programs, summary)
    run(export, folder, programs, summary)
    assert (folder / "hri-report" / "cobertura.xml").is_file()
    shutil.rmtree(tmp_path)  # environments are large, and pytest keeps the folders of several sessions


def test_what_the_workflow_uploads_is_what_its_commands_write() -> None:
    text = workflow()
    uploaded = re.findall(r"^ +path: (.*)$", text, re.MULTILINE)
    written = re.findall(r"(?:--hri-report=|-o )(\S+?(?:\$\{\{.*?\}\})?)(?=\s)", text)
    assert len(uploaded) == 2
    assert set(uploaded) <= set(written)
