"""The same code, world, requirements, faults and processor time for several tools; `protocol.md` says how."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.coverage.code_map import CodeMap, map_code
from studies.localization.projects import HELD_OUT, PROJECTS
from studies.wild import packages

FOLDER = Path(__file__).parent
ROOT = FOLDER.parents[1]

_FUZZED = """\
from hypothesis import settings

from studies.fair_fight.drawing import machine
from studies.fair_fight.world import World

TestPerson = machine(World.here("{name}")).TestCase
TestPerson.settings = settings(stateful_step_count=30, deadline=None)
"""


@dataclass(frozen=True)
class CodeBase:
    """Code under test with its testbench.

    Args:
        name: as `--only` names it.
        title: as the page calls it.
        code: importable names of its code under test.
        lay: writes its files into a folder that is not there yet; gets the folder of clones, too.
        options: of pytest, for our own suites.
        python_path: folders that Python imports from, below its folder.
        fidelity: how its world is simulated; empty where it knows only one way.
        replay_s: processor time for the inputs of a tool on a sealed fault.
    """

    name: str
    title: str
    code: tuple[str, ...]
    lay: Callable[[Path, Path], None]
    options: tuple[str, ...] = ()
    python_path: tuple[str, ...] = ()
    fidelity: str = ""
    replay_s: float = 4.0

    def fill(self, folder: Path, clones: Path) -> None:
        """Write its files, and the test that HypoFuzz collects. Raises FetchError where it cannot be cloned."""
        shutil.rmtree(folder, ignore_errors=True)
        self.lay(folder, clones)
        (folder / "test_fuzzed.py").write_text(_FUZZED.format(name=self.name), encoding="utf-8")

    def map(self, folder: Path) -> CodeMap:
        """Its code under test, in a folder that was filled."""
        places = [str(folder / each) for each in (*self.python_path, ".")]
        sys.path[:0] = places
        try:
            return map_code(self.code, folder)
        finally:
            del sys.path[: len(places)]


def _project(name: str) -> Callable[[Path, Path], None]:
    project = next(each for each in (*PROJECTS, *HELD_OUT) if each.name == name)

    def lay(folder: Path, clones: Path) -> None:
        folder.mkdir(parents=True)
        project.fill(folder)

    return lay


def _package(key: str) -> Callable[[Path, Path], None]:
    package = next(each for each in packages() if each.key == key)

    def lay(folder: Path, clones: Path) -> None:
        shutil.copytree(package.lay(clones), folder, symlinks=True)

    return lay


CODE_BASES = (
    CodeBase(
        "table",
        "table assembly",
        ("controller",),
        _project("table"),
        options=("tests/hri/test_table_assembly.py", "--hri-fidelity=kinematic"),
        fidelity="kinematic",
    ),
    CodeBase(
        "home_care",
        "home care",
        ("carebot",),
        _project("home_care"),
        options=("tests/test_home_care.py",),
        replay_s=10.0,
    ),
    CodeBase(
        "tello",
        "`DJITelloPy`",
        ("djitellopy.tello",),
        _package("tello"),
        options=("test_bench.py",),
        python_path=("src/DJITelloPy",),
    ),
)
