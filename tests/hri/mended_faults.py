"""Faults of the controller that closing loops uncovered and that were mended; each patch in `mended` puts one back.

So suites, and what says where faults are, can be measured on faults that nobody planted.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import controller
from tests.hri import bench
from tests.hri.disturbed import Line

PATCHES = Path(__file__).parent / "mended"
KEPT = ("controller", "controller.ports")
"""Modules that the world knows, too."""


@dataclass(frozen=True)
class MendedFault:
    """A fault that was mended.

    Args:
        name: of its patch.
        function: of the controller that has it.
        lines: of a test that fails with it and passes without.
        violated: the requirements that this test then violates, beyond what is known of them.
    """

    name: str
    function: str
    lines: Sequence[Line]
    violated: str


LEG, NOT_READY = bench.leg("111"), bench.leg("011")

FAULTS = (
    MendedFault(
        "drops_where_it_stands",
        "controller/finishing.py: emptied",
        [("somebody_in_the_way", {"place": 2, "after_s": 1.0, "for_s": 60.0}), *NOT_READY],
        "R2 R16 R22",
    ),
    MendedFault(
        "goes_home_with_the_leg",
        "controller/finishing.py: discard",
        [("hand_held_shut", {"grip_s": 40.0}), *NOT_READY],
        "R16 R29 R21",
    ),
    MendedFault(
        "closes_on_the_person",
        "controller/finishing.py: release",
        [("hand_held_shut", {"grip_s": 20.0}), *LEG],
        "R3",
    ),
    MendedFault(
        "discards_along_the_table",
        "controller/fetching.py: fetch",
        [("somebody_in_the_way", {"place": 1, "after_s": 1.0, "for_s": 60.0}), *LEG],
        "R29",
    ),
    MendedFault(
        "begins_with_a_leg_in_the_hand",
        "controller/fetching.py: reset",
        [("leg_in_hand", {}), ("hand_held_shut", {"grip_s": 20.0}), *bench.leg("110")],
        "R29 R20",
    ),
)


def patched(name: str, folder: Path) -> Path:
    """A copy of the controller in a folder, with a fault put back; the path of the package."""
    package = folder / "controller"
    shutil.copytree(Path(controller.__file__).parent, package, ignore=shutil.ignore_patterns("__pycache__"))
    subprocess.run(["git", "apply", str(PATCHES / f"{name}.patch")], cwd=folder, check=True, timeout=60)
    return package


@contextmanager
def planted(name: str, folder: Path) -> Iterator[None]:
    """Within it, runs of the table have the controller with a fault put back."""
    path, package = controller.__path__, patched(name, folder)
    whole = {module: sys.modules.pop(module) for module in _replaced()}
    controller.__path__ = [str(package)]
    _forget(whole)
    try:
        yield
    finally:
        replaced = _replaced()
        _forget(replaced)
        for module in replaced:
            del sys.modules[module]
        controller.__path__ = path
        for module, code in whole.items():
            sys.modules[module] = code
            setattr(controller, module.rpartition(".")[2], code)


def _replaced() -> list[str]:
    return [name for name in sys.modules if name.startswith("controller.") and name not in KEPT]


def _forget(modules: Iterable[str]) -> None:
    """Let the package import them again."""
    for module in modules:
        vars(controller).pop(module.rpartition(".")[2], None)
