"""What a launch file asks to be started: which Python code that is, or what stands for it."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from pytest_hricdv._base.message import MAX_LINE, cut
from pytest_hricdv._base.suggestion import nearest
from pytest_hricdv.declarations.ros2 import IGNORED, Launch, LaunchError, Process
from pytest_hricdv.extra.ros2.packages import SourcePackage, console_scripts, find_executable, is_binary

_CONTAINERS = "rclcpp_components/component_container*"
"""Containers of composable nodes: only what is loaded into them is a matter of the testbench."""
_PATH_LENGTH = 3
"""Of the end of an executable's path: lib/PACKAGE/EXECUTABLE."""


class RefusedError(LaunchError):
    """An executable that is not Python, and for which nothing stands.

    Args:
        name: in `Launch.executables`.
        message: that says so.
    """

    def __init__(self, name: str, message: str) -> None:
        super().__init__(message)
        self.name = name


@dataclass(frozen=True)
class Command:
    """A command line of a launch file.

    Args:
        name: "package/executable" of a node, else the command's first word.
        argv: its `sys.argv`.
    """

    name: str
    argv: tuple[str, ...]

    def __str__(self) -> str:
        return self.name if "/" in self.name else cut(shlex.join(self.argv), MAX_LINE)


def is_container(name: str) -> bool:
    """Whether an executable is a container of composable nodes."""
    return fnmatchcase(name, _CONTAINERS)


def command(words: Sequence[str]) -> Command:
    """What a list of words starts: terminals and debuggers before a node are left out."""
    for number, word in enumerate(words):
        parts = Path(word).parts[-_PATH_LENGTH:]
        if len(parts) == _PATH_LENGTH and parts[0] == "lib" and Path(word).is_absolute():
            return Command(f"{parts[1]}/{parts[2]}", tuple(words[number:]))
    if list(words[:2]) == ["ros2", "run"] and len(words) > _PATH_LENGTH:
        return Command(f"{words[2]}/{words[3]}", tuple(words[3:]))
    return Command(Path(words[0]).name if words else "", tuple(words))


@dataclass(frozen=True)
class Executables:
    """Where the code of what a launch file starts is.

    Args:
        launch: the declaration, with what stands for executables.
        sources: packages that are there as sources, by name.
    """

    launch: Launch
    sources: Mapping[str, SourcePackage]

    def of(self, wanted: Command) -> Process | str:
        """A function that stands for it, an entry "package.module:main", or `IGNORED`.

        Raises:
            LaunchError: it is not Python, and nothing stands for it; its package is not there; or it has no such
                executable.
        """
        replaced = self.replacement(wanted.name, shlex.join(wanted.argv))
        if replaced is not None:
            return replaced
        if is_container(wanted.name):
            return IGNORED
        package, slash, executable = wanted.name.partition("/")
        if not slash:
            raise self._refusal(str(wanted), wanted.name, "is a command of the system, which no simulated run has")
        scripts = console_scripts(package, self.sources)
        if executable in (scripts or {}):
            assert scripts is not None
            self._add_to_path(package)
            return scripts[executable]
        raise self._executable_error(package, executable, scripts)

    def replacement(self, *names: str) -> Process | str | None:
        """What the testbench has in the place of what has one of these names; None if there is nothing."""
        patterns = self.launch.executables
        exact = next((patterns[name] for name in names if name in patterns), None)
        if exact is not None:
            return exact
        return next((patterns[key] for key in patterns if any(fnmatchcase(name, key) for name in names)), None)

    def component(self, package: str, plugin: str) -> Process | str:
        """What stands for a composable node.

        Raises:
            LaunchError: nothing does.
        """
        name = f"{package}/{plugin}"
        replaced = self.replacement(name)
        if replaced is None:
            raise self._refusal(f"composable node {name}", name, "is a class of C++, loaded into a container")
        return replaced

    def _add_to_path(self, package: str) -> None:
        """Let modules of a source be found, unless they are on the path already."""
        if package in self.sources:
            folder = self.sources[package].folder
            root = folder / "src" if not (folder / package).is_dir() and (folder / "src").is_dir() else folder
            if str(root) not in sys.path:
                sys.path.append(str(root))

    def _executable_error(self, package: str, executable: str, scripts: Mapping[str, str] | None) -> LaunchError:
        name, file = f"{package}/{executable}", find_executable(package, executable)
        source = self.sources.get(package)
        if file is not None:
            problem = (
                f"is a compiled program, as of C++, {file}"
                if is_binary(file)
                else f"is a program that is no console script of Python, {file}"
            )
            return self._refusal(name, name, problem)
        if source is not None and (source.folder / "CMakeLists.txt").is_file():
            return self._refusal(name, name, f"is built by CMake, in {source.folder}, as programs of C++ are")
        if scripts:
            return LaunchError(
                f"{self.launch}: package {package!r} has no executable {executable!r}; it has "
                f"{', '.join(sorted(scripts))}{nearest(executable, list(scripts))}"
            )
        if scripts is not None:
            where = source.folder if source is not None else "as it is installed"
            return LaunchError(
                f"{self.launch}: package {package!r}, {where}, declares no console script, so no {executable!r}; see "
                "entry_points in its setup.py"
            )
        return self._refusal(name, name, f"is of package {package!r}, which is neither installed nor in the workspace")

    def _refusal(self, what: str, name: str, problem: str) -> RefusedError:
        return RefusedError(
            name,
            f"{self.launch}: {what} {problem}. Say what stands for it, a function or an entry of Python, or leave it "
            f'out: Launch(..., executables={{"{name}": stand_in}}) or {{"{name}": "{IGNORED}"}}',
        )
