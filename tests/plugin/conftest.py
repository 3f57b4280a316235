"""The user's project that the plugin is tested on, written into a fresh folder for each test."""

from __future__ import annotations

import importlib
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import coverage.collector
import pytest

from pytest_hricdv.registry import offers
from pytest_hricdv.session.child_process import PRELOADED
from tests.plugin import project

ENVIRONMENT = ("PY_COLORS", "FORCE_COLOR", "NO_COLOR", "COLUMNS", "CI", "GITHUB_ACTIONS", "GITHUB_STEP_SUMMARY")

for _name in (
    "pytest_hricdv.bdi.language.syntax_errors",
    "pytest_hricdv.bdi.language.transformer",
    "pytest_hricdv.bdi.lint",
    "pytest_hricdv.extra.campaign.view",
    "pytest_hricdv.generate.model_runner",
    "pytest_hricdv.monitor.pattern_parser",
    "pytest_hricdv.report.html",
    "pytest_hricdv.session.breaking",
    *PRELOADED,
    *(f"pytest_hricdv.runtime.virtual.{name}" for name in ("asyncio_functions", "thread_pool", "threads")),
    *(f"pytest_hricdv.session.{name}" for name in ("early_end", "running", "terminal_summary")),
):
    # Loaded once: runs of pytest in this process drop what they loaded themselves, and extension modules like the
    # tracer do not take well to being loaded again.
    importlib.import_module(_name)

# It names the caller in coverage's debugging output; in a session within a session it is a fifth of the time.
vars(coverage.collector)["short_stack"] = lambda *_, **__: ""

for _role in ("command", "execution", "feature", "records", "view"):
    offers(_role, "")


@dataclass(frozen=True)
class FinishedSession:
    """A session of pytest in the unchanged lamps project.

    Attributes:
        path: the project's folder. Tests share it and leave it as it is.
        result: exit status and output.
    """

    path: Path
    result: pytest.RunResult


SessionRunner = Callable[..., FinishedSession]
"""Takes the options of pytest."""


@pytest.fixture(scope="session")
def finished_sessions() -> dict[tuple[str, ...], FinishedSession]:
    """Options -> the session with these options."""
    return {}


@pytest.fixture
def finished(
    lamps: pytest.Pytester,
    finished_sessions: dict[tuple[str, ...], FinishedSession],
    tmp_path_factory: pytest.TempPathFactory,
) -> SessionRunner:
    """Runs pytest in the unchanged lamps project, once for all tests that ask for the same options."""

    def run(*options: str) -> FinishedSession:
        if options not in finished_sessions:
            folder = tmp_path_factory.mktemp("session")
            project.write(folder)
            with pytest.MonkeyPatch.context() as patch:
                patch.chdir(folder)
                finished_sessions[options] = FinishedSession(folder, lamps.runpytest_inprocess(*options))
        return finished_sessions[options]

    return run


@pytest.fixture
def after(lamps: pytest.Pytester, finished: SessionRunner) -> SessionRunner:
    """Puts a copy of what `finished` sessions left into the project of the test, which may go on from there."""

    def copy(*options: str) -> FinishedSession:
        session = finished(*options)
        compiled = shutil.ignore_patterns("__pycache__")  # it has the names of the other folder
        shutil.copytree(session.path, lamps.path, ignore=compiled, dirs_exist_ok=True)
        return FinishedSession(lamps.path, session.result)

    return copy


@pytest.fixture(scope="session")
def cache_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The user's folder of caches and state, of all tests; with one for each, as with `pytester`, each builds all
    parsers anew."""
    return tmp_path_factory.mktemp("cache")


@pytest.fixture
def lamps(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch, cache_folder: Path) -> pytest.Pytester:
    """A `pytester` in whose folder the lamps project lies; its runs see nothing of the run they are part of."""
    for name in (*ENVIRONMENT, "PYTEST_XDIST_WORKER"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache_folder))
    monkeypatch.setenv("XDG_STATE_HOME", str(cache_folder))
    project.write(pytester.path)
    return pytester
