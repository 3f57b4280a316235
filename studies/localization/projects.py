"""The testbenches whose code gets faults: each in a folder of its own, and the options its tests are run with."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.coverage.code_map import CodeMap, map_code
from studies import session
from studies.examples import blocks_of, write_files

_DOCS = session.ROOT / "docs"

SUITE = Path(__file__).with_name("table.txt")
"""Of the table: each outcome of a handover, more than one leg, and disturbances, among them those with which the mended
faults of tests/hri show. A learned suite would take minutes for each fault."""

_TABLE = ("conftest.py", "pyproject.toml", "controller", "sim", "models_bdi", "tests/__init__.py", "tests/hri")
"""What the table's tests need of this repository."""


@dataclass(frozen=True)
class Project:
    """A testbench.

    Args:
        name: of the testbench, as people call it.
        code: importable names of its code under test.
        options: of pytest, beside the report's folder.
        fill: writes its files into a folder.
    """

    name: str
    code: tuple[str, ...]
    options: tuple[str, ...]
    fill: Callable[[Path], None]

    def map(self, folder: Path) -> CodeMap:
        """Its code under test, in a folder that was filled."""
        sys.path.insert(0, str(folder))
        try:
            return map_code(self.code, folder)
        finally:
            sys.path.remove(str(folder))


def _of_page(page: Path) -> Callable[[Path], None]:
    def fill(folder: Path) -> None:
        write_files(blocks_of(page), folder)

    return fill


def _table(folder: Path) -> None:
    for name in _TABLE:
        source, target = session.ROOT / name, folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.is_dir():
            shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, target)
    shutil.copy(SUITE, folder / SUITE.name)


_HOME_CARE = "examples/home_care"


def _home_care(folder: Path) -> None:
    ignored = shutil.ignore_patterns("__pycache__", ".*", "hri-report*", "*.png", "studies")
    shutil.copytree(session.ROOT / _HOME_CARE, folder, ignore=ignored, dirs_exist_ok=True)


PROJECTS = (
    Project("coffee", ("barista", "pouring"), ("--hri-suite=rl",), _of_page(_DOCS / "tutorial.md")),
    Project("vacuum", ("vacuum",), ("--hri-suite=rl",), _of_page(_DOCS / "vacuum.md")),
    # Without masses and forces a run takes a fraction of the time, and the controller is the same.
    Project("table", ("controller",), (f"--hri-suite={SUITE.name}", "--hri-fidelity=kinematic"), _table),
)
"""In the order in which they are measured: the cheapest first."""

_FEEDING = ("feeder", "behaviours", "arm", "guard", "sensing", "meal")

HELD_OUT = (
    Project("tray", ("porter", "lid"), ("--hri-suite=rl",), _of_page(Path(__file__).with_name("tray.md"))),
    Project("feeding", _FEEDING, ("--hri-suite=rl",), _of_page(Path(__file__).with_name("feeding.md"))),
    Project("lift", ("lift",), ("--hri-suite=rl",), _of_page(Path(__file__).with_name("lift.md"))),
    Project("home_care", ("carebot",), ("--hri-suite=by-hand",), _home_care),
)
"""On which nothing of a diagnosis was chosen; measured where they are named. A session of the second takes minutes."""
