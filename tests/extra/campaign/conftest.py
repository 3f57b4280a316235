"""The user's project that campaigns are tried on, and what runs them."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from tests.plugin import project

Campaign = Callable[..., subprocess.CompletedProcess[str]]
Finished = tuple[Path, subprocess.CompletedProcess[str]]
SUITE = ("--suite=bdi-random", "--tests=4")
RUN = ("run", *SUITE, "--concretizations=5", "--cluster=local:1", "--state=a.db")


def environment() -> dict[str, str]:
    """Of a process that is not part of a test run."""
    given = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST_", "COV_", "COVERAGE_"))}
    root = str(Path(__file__).parents[3])
    return {**given, "PYTHONPATH": root, "COLUMNS": "80"}


@pytest.fixture
def lamps(tmp_path: Path) -> Path:
    """A user's project."""
    folder = tmp_path / "project"
    folder.mkdir()
    project.write(folder)
    return folder


def command(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """A command of a campaign in a project, as a process of its own."""
    given = [sys.executable, "-m", "pytest_hricdv.campaign", *arguments]
    return subprocess.run(
        given, cwd=folder, env=environment(), capture_output=True, text=True, timeout=300, check=False
    )


@pytest.fixture
def campaign(lamps: Path) -> Campaign:
    """A command of a campaign in the user's project."""
    return partial(command, lamps)


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Finished:
    """A project with a campaign that was run, and what it said; for tests that leave both as they are."""
    folder = tmp_path_factory.mktemp("finished") / "project"
    folder.mkdir()
    project.write(folder)
    return folder, command(folder, *RUN)


@pytest.fixture
def begun(finished: Finished, lamps: Path) -> Path:
    """A project with a copy of that campaign."""
    shutil.copy(finished[0] / "a.db", lamps / "a.db")
    return lamps
