"""Builds the inner modules of the engines ahead of time: a hook of the build of wheels, of no use when tests run.

A wheel holds these modules twice: as Python, and compiled by mypyc and the machine's C compiler, which Python then
prefers. Both do the same; compiled they take a third to a half of the time. An editable install, as in a checkout,
stays Python: what is edited is what runs. So does a wheel that is built without a C compiler, or with
``HRICDV_PURE=1``.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

PACKAGE = "pytest_hricdv"
GROUP = f"{PACKAGE}_bdi"
"""What the one extension module is called that holds all of them."""
ENGINES = (
    *("agent", "beliefs", "blocks", "books", "calling", "communication", "company", "conditions"),
    *("execution", "failure", "instances", "intentions", "jitter", "library", "mind"),
    *("participant", "perception", "quiet", "scheduler", "selection", "spinning"),
    *("traced", "updates", "values", "waiting", "whereabouts"),
    *("language/arithmetic", "language/formulas", "language/syntax", "language/terms"),
    *("logic/comparison", "logic/inference", "logic/substitution", "logic/unify"),
)
COMPILED = ("activity", "agent", "changes", "code", "effects", "handover", "mind", "posting", "program", "runtime")
MEMO = ("diagram", "engine", "forwarding", "recording", "state", "steering", "survey", "watching")
SETUP = """
from mypyc.build import mypycify
from setuptools import setup

setup(name={group!r}, ext_modules=mypycify(["--ignore-missing-imports", *{files!r}], group_name={group!r}))
"""


class NativeBuildHook(BuildHookInterface[Any]):
    """Adds the compiled modules to a wheel."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile, before the wheel is put together; if that cannot be done, the wheel is pure Python."""
        if version == "editable" or os.environ.get("HRICDV_PURE") == "1":
            return
        self._folder = TemporaryDirectory(prefix=f"{PACKAGE}-")
        folder = Path(self._folder.name)
        try:
            compile_modules(Path(self.root), folder)
        except subprocess.CalledProcessError as error:
            self.app.display_warning(f"the wheel will be pure Python, and the engines slower:\n{error.stdout[-2000:]}")
            return
        built = folder / "built"
        build_data["force_include"] |= {str(each): str(each.relative_to(built)) for each in modules_in(built)}
        build_data |= {"infer_tag": True, "pure_python": False}

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """The wheel is there."""
        if hasattr(self, "_folder"):
            self._folder.cleanup()


def modules_in(folder: Path) -> list[Path]:
    """The extension modules in a folder."""
    return sorted(each for each in folder.rglob("*") if each.suffix in (".so", ".pyd"))


def compile_modules(root: Path, folder: Path) -> None:
    """Compile a copy of the package: nothing is left beside the sources that could be taken for them later.

    Args:
        root: of the project.
        folder: where to work; the extension modules are in its subfolder ``built`` then, as in the package.

    Raises:
        subprocess.CalledProcessError: that went wrong; with what was printed.
    """
    shutil.copytree(root / PACKAGE, folder / PACKAGE, ignore=shutil.ignore_patterns("__pycache__", "*.so", "*.pyd"))
    places = [f"{name}.py" for name in ENGINES]
    places += [f"compiled/{name}.py" for name in COMPILED] + [f"memo/{name}.py" for name in MEMO]
    files = [f"{PACKAGE}/bdi/{place}" for place in places]
    (folder / "setup.py").write_text(SETUP.format(group=GROUP, files=files), encoding="utf-8")
    command = [sys.executable, "setup.py", "build_ext", "--build-lib", "built", "--build-temp", "objects"]
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
