"""Finds the Python code of the executables of nodes and launch files, or what replaces them in a testbench.

`Executables.of` returns the code for a `Command` of a launch file (`launch_processes` calls it). For a declared
`RosNode`, `entry_point` returns the entry and `load` the main function (`Ros2Overlay` and `Ros2Execution` call them).
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from pytest_hricdv._base.message import MAX_LINE, cut, nearest
from pytest_hricdv.declarations.ros2 import (
    IGNORED,
    Launch,
    LaunchError,
    MissingExecutableError,
    Process,
    Ros2Error,
    RosNode,
)
from pytest_hricdv.extra.ros2.arguments import command_line
from pytest_hricdv.extra.ros2.entries import load_entry
from pytest_hricdv.extra.ros2.packages import (
    SourcePackage,
    console_scripts,
    find_executable,
    is_binary,
    packages_in,
)

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

_CONTAINERS = "rclcpp_components/component_container*"
"""Pattern of the containers of composable nodes, which are ignored: a testbench replaces the nodes loaded into them."""
_PATH_LENGTH = 3
"""Number of last parts of an executable's path that identify it: lib/PACKAGE/EXECUTABLE."""


class ForeignExecutableError(LaunchError):
    """An executable is not Python and has no replacement; `name` is its name in `Launch.executables`."""

    def __init__(self, name: str, message: str) -> None:
        super().__init__(message)
        self.name = name


@dataclass(frozen=True)
class Command:
    """A command line of a launch file.

    Args:
        name: "package/executable" of a node, else the command's first word.
        argv: the whole command line, `sys.argv` of its process.
    """

    name: str
    argv: tuple[str, ...]

    def __str__(self) -> str:
        return self.name if "/" in self.name else cut(shlex.join(self.argv), MAX_LINE)


def is_container(name: str) -> bool:
    """Whether an executable is a container of composable nodes."""
    return fnmatchcase(name, _CONTAINERS)


def command(words: Sequence[str]) -> Command:
    """The command in a list of words, without terminals and debuggers before a node."""
    for number, word in enumerate(words):
        parts = Path(word).parts[-_PATH_LENGTH:]
        if len(parts) == _PATH_LENGTH and parts[0] == "lib" and Path(word).is_absolute():
            return Command(f"{parts[1]}/{parts[2]}", tuple(words[number:]))
    if list(words[:2]) == ["ros2", "run"] and len(words) > _PATH_LENGTH:
        return Command(f"{words[2]}/{words[3]}", tuple(words[3:]))
    return Command(Path(words[0]).name if words else "", tuple(words))


@dataclass(frozen=True)
class Executables:
    """Locates the code of the executables that a launch file starts, also in packages in source form."""

    launch: Launch
    sources: Mapping[str, SourcePackage]

    def of(self, wanted: Command) -> Process | str:
        """A function that replaces it, an entry "package.module:main", or `IGNORED`.

        Raises:
            LaunchError: it is not Python, and nothing replaces it; its package is not there; or it has no such
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
            add_to_path(package, self.sources)
            return scripts[executable]
        raise self._executable_error(package, executable, scripts)

    def replacement(self, *names: str) -> Process | str | None:
        """The testbench's replacement for one of these names; None if there is none."""
        patterns = self.launch.executables
        exact = next((patterns[name] for name in names if name in patterns), None)
        if exact is not None:
            return exact
        return next((patterns[key] for key in patterns if any(fnmatchcase(name, key) for name in names)), None)

    def component(self, package: str, plugin: str) -> Process | str:
        """The replacement for a composable node.

        Raises:
            LaunchError: there is none.
        """
        name = f"{package}/{plugin}"
        replaced = self.replacement(name)
        if replaced is None:
            raise self._refusal(f"composable node {name}", name, "is a class of C++, loaded into a container")
        return replaced

    def _executable_error(self, package: str, executable: str, scripts: Mapping[str, str] | None) -> LaunchError:
        name, source = f"{package}/{executable}", self.sources.get(package)
        if program := _describe_program(package, executable):
            return self._refusal(name, name, program)
        if source is not None and (source.folder / "CMakeLists.txt").is_file():
            return self._refusal(name, name, f"is built by CMake, in {source.folder}, as programs of C++ are")
        if scripts is None:
            problem = f"is of package {package!r}, which is neither installed nor in the workspace"
            return self._refusal(name, name, problem)
        if scripts:
            return LaunchError(f"{self.launch}: {_describe_scripts(package, executable, scripts)}")
        where = source.folder if source is not None else "as it is installed"
        return LaunchError(
            f"{self.launch}: package {package!r}, {where}, declares no console script, so no {executable!r}; see "
            "entry_points in its setup.py"
        )

    def _refusal(self, what: str, name: str, problem: str) -> ForeignExecutableError:
        return ForeignExecutableError(
            name,
            f"{self.launch}: {what} {problem}. Replace it by a function or an entry of Python, or leave it "
            f'out: Launch(..., executables={{"{name}": replacement}}) or {{"{name}": "{IGNORED}"}}',
        )


def add_to_path(package: str, sources: Mapping[str, SourcePackage]) -> None:
    """Let modules of a source be found, unless they are on the path already."""
    if package in sources:
        folder = sources[package].folder
        root = folder / "src" if not (folder / package).is_dir() and (folder / "src").is_dir() else folder
        if str(root) not in sys.path:
            sys.path.append(str(root))


def entry_point(node: RosNode) -> str:
    """The location of a node's code, "package.module:name".

    An installed package precedes one of the workspace; modules of the latter can be imported afterwards.

    Raises:
        MissingExecutableError: there is no such package or executable, or it is not written in Python.
    """
    if node.entry:
        return node.entry
    entries = console_scripts(node.package, {}) or {}
    if node.executable not in entries:
        sources = packages_in(node.workspace)
        entries = console_scripts(node.package, sources) or entries
        if node.executable not in entries:
            raise _not_a_script(node, list(entries), sources)
        add_to_path(node.package, sources)
    return entries[node.executable]


def _not_a_script(node: RosNode, scripts: Sequence[str], sources: Mapping[str, SourcePackage]) -> LaunchError:
    if program := _describe_program(node.package, node.executable):
        return MissingExecutableError(
            f'{node}: {program}; name a function of Python as entry="package.module:main", or simulate what it does, '
            "with run.ros2(...).node(...)"
        )
    if scripts:
        problem = _describe_scripts(node.package, node.executable, scripts)
    elif node.package in sources:
        problem = f"package {node.package!r}, in {sources[node.package].folder}, declares no console scripts"
    else:
        problem = (
            f"package {node.package!r} is neither installed nor below {Path().absolute()}"
            f"{nearest(node.package, list(sources))}"
        )
    return MissingExecutableError(
        f"{node}: {problem}. Name the folder with its sources, RosNode(..., workspace=[...]), source the workspace's "
        'setup file, or name the function as entry="package.module:main"'
    )


def _describe_program(package: str, executable: str) -> str:
    """A description of an installed program that is not a console script; empty if there is none."""
    file = find_executable(package, executable)
    if file is None:
        return ""
    kind = "a compiled program, as of C++" if is_binary(file) else "a program that is not a console script"
    return f"is {kind}, {file}"


def _describe_scripts(package: str, executable: str, scripts: Collection[str]) -> str:
    has = f"it has {', '.join(sorted(scripts))}{nearest(executable, list(scripts))}"
    return f"package {package!r} has no executable {executable!r}; {has}"


def require_virtual_package(what: str, entry: str, packages: Collection[str]) -> None:
    """Refuse an entry "package.module:name" that does not see virtual time.

    Raises:
        Ros2Error: its module is in none of `packages`, which may be modules of a package.
    """
    module = entry.partition(":")[0]
    package = module.partition(".")[0]
    if not any(f"{module}.".startswith(f"{other}.") for other in packages):
        raise Ros2Error(
            f"{what}: its package {package!r} is neither in the testbench's code nor in Ros2(packages=...); add it "
            "there, so that it sees virtual time"
        )


def load(node: RosNode) -> Callable[[], object]:
    """Import the code of a node; what its process is to call.

    Raises:
        LaunchError: there is no such module, or no such name in it.
    """
    return load_entry(str(node), entry_point(node), command_line(node))
