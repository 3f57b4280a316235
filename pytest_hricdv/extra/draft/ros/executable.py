"""Finds the Python code of a ROS 2 executable: "PACKAGE EXECUTABLE", as for `ros2 run`, or the path of a file.

The feature `ros2`, which may be missing, provides the tools for this.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, cast

from pytest_hricdv._base.message import nearest
from pytest_hricdv.extra.draft.code.loading import find
from pytest_hricdv.extra.draft.code.sources import DraftError, Sources
from pytest_hricdv.extra.draft.ros.nodes import NODES
from pytest_hricdv.registry import offers


class RosTools(Protocol):
    """Finds ROS 2 packages and their executables; `packages` maps names to folders with a package.xml."""

    def packages(self, *folders: Path) -> dict[str, Path]:
        """The packages in these folders and around them."""

    def console_scripts(self, package: str, packages: Mapping[str, Path]) -> dict[str, str] | None:
        """Name -> "package.module:function", for a package in source or installed; None if it is neither."""


def ros_tools() -> RosTools:
    """The tools. Raises DraftError if there is no feature `ros2`."""
    offered = offers("drafting", "ROS_TOOLS")
    if not offered:
        raise DraftError("ROS 2 nodes need the feature `ros2`, which this installation does not have")
    return cast(RosTools, offered[0])


_FOLDERS = ("scripts", "nodes", "bin", "src", "")
"""Folders in which a package built with CMake usually keeps its Python programs; "" is the package itself."""


@dataclass(frozen=True)
class Executable:
    """A node that a testbench can start.

    Args:
        asked: the executable as the user named it.
        entry: "package.module:function", or a class of nodes.
        sources: its module, and the neighbouring code that it imports.
        packages: the packages of the workspace, by name, for their interface files.
    """

    asked: str
    entry: str
    sources: Sources
    packages: Mapping[str, Path]


def find_executable(asked: str, start: Path) -> Executable:
    """Find the code of "PACKAGE EXECUTABLE", or of a file, "PATH.py" or "PATH.py:FUNCTION".

    Args:
        start: the folder of the workspace or package, in which to look for sources.

    Raises:
        DraftError: there is no such package or executable, or it is not Python.
    """
    words = asked.split()
    if len(words) == 1 and words[0].partition(":")[0].endswith(".py"):
        return _read_file(asked, words[0], start)
    if len(words) != 2:
        raise DraftError(
            f'--ros2={asked!r}: expected "PACKAGE EXECUTABLE", as for `ros2 run`, or the path of a .py file'
        )
    package, name = words
    packages = ros_tools().packages(start)
    scripts = ros_tools().console_scripts(package, packages)
    if scripts is None:
        raise DraftError(
            f"--ros2: package {package!r} is neither installed nor in {start}"
            f"{nearest(package, list(packages))}; run it in the folder of your workspace, "
            "or give the path of the node's file"
        )
    if name in scripts:
        return _read_script(asked, scripts[name], packages.get(package), start, packages)
    if package in packages:
        for file in _programs(packages[package], package, name):
            return _read_file(asked, str(file), start)
    raise DraftError(
        f"--ros2: package {package!r} has no Python executable {name!r}{nearest(name, list(scripts))}; "
        + (f"it has {', '.join(sorted(scripts))}" if scripts else "give the path of the node's file, if it is Python")
    )


def _programs(folder: Path, package: str, name: str) -> list[Path]:
    """Python files that CMake may install as a program of this name."""
    stem = name.removesuffix(".py")
    files = [folder / part / f"{stem}.py" for part in (*_FOLDERS, package)]
    return [file for file in files if file.is_file()]


def _read_script(asked: str, entry: str, package: Path | None, start: Path, packages: Mapping[str, Path]) -> Executable:
    module, _, function = entry.partition(":")
    root = start
    if package is not None:
        is_below = not (package / module.partition(".")[0]).exists() and (package / "src").is_dir()
        root = package / "src" if is_below else package
    try:
        sources = find(module, root)
    except DraftError as error:
        raise DraftError(f"--ros2={asked!r}: its entry point is {entry}; {str(error).replace('--from=', '')}") from None
    own = sources.by_name.get(module)
    if own is not None and sources.definition(own, function) is None:
        raise DraftError(
            f"--ros2={asked!r}: its entry point {function!r} is not in {own.file}{nearest(function, list(own.scope))}"
        )
    return Executable(asked, entry, sources, packages)


def _read_file(asked: str, path: str, start: Path) -> Executable:
    name, _, function = path.partition(":")
    file = (start / name).expanduser().resolve()
    if not file.is_file():
        raise DraftError(f"--ros2={asked!r}: there is no file {file}")
    sources = find(str(file), start)
    module = next((module for module in sources.modules if (sources.root / module.file) == file), None)
    if module is None:
        raise DraftError(f"--ros2={asked!r}: {file} cannot be read: {sources.problems[0].text}")
    if not function:
        classes = [s.node.name for s in sources.classes if s.module is module and isinstance(s.node, ast.ClassDef)
                   and any(base in NODES for base in sources.bases(s))]  # fmt: skip
        function = "main" if "main" in module.scope else classes[-1] if classes else ""
    if not function or sources.definition(module, function) is None:
        lacks = function or "function main and no node class"
        raise DraftError(f"--ros2={asked!r}: {module.file} has no {lacks}; give PATH.py:FUNCTION")
    return Executable(asked, f"{module.name}:{function}", sources, ros_tools().packages(start, file.parent))
