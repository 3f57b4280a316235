"""Finds ROS 2 packages in source form in a workspace, and the console scripts that they declare.

`launch_files` calls `packages_around` for the packages around a launch file, `executables` calls `console_scripts` for
the code of an executable. A package that is not built is missing in the index of packages: `add_to_index` makes a
folder of markers, as `colcon build --symlink-install` would, for AMENT_PREFIX_PATH while launch files run.
"""

from __future__ import annotations

import ast
import configparser
import os
import re
import sys
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from pathlib import Path
from xml.etree import ElementTree

from pytest_hricdv.declarations.ros2 import LaunchError

_MANIFEST = "package.xml"
_NO_SOURCES = frozenset({"build", "install", "log", "node_modules", "site-packages", "__pycache__"})
"""Folders of a workspace that have no sources, but what colcon, Python and npm have made or installed."""
# A folder with one of these files has no packages
_IGNORING = ("COLCON_IGNORE", "AMENT_IGNORE", "CATKIN_IGNORE")
_DEPTH = 4
"""Greatest depth of packages below a workspace: src/repository/group/package."""

_MARKERS = Path("share") / "ament_index" / "resource_index" / "packages"


@dataclass(frozen=True)
class SourcePackage:
    """A folder with a package.xml."""

    name: str
    folder: Path

    @property
    def scripts(self) -> dict[str, str]:
        """Console scripts that it declares: name -> "package.module:function"."""
        return _scripts(self.folder)


def packages_around(file: Path, workspace: Iterable[Path] = ()) -> dict[str, SourcePackage]:
    """Packages whose sources are near a file: the package that the file is in, its neighbours, and those of workspaces.

    Args:
        file: a file, such as a launch file.
        workspace: other folders; their packages take precedence.
    """
    own = next((folder for folder in file.absolute().parents if (folder / _MANIFEST).is_file()), None)
    roots = [*workspace, *([] if own is None else [own, *_neighbourhood(own)])]
    packages: dict[str, SourcePackage] = {}
    for root in roots:
        for package in sources_in(root.absolute()):
            packages.setdefault(package.name, package)
    return packages


def packages_in(workspace: Iterable[str | Path]) -> dict[str, SourcePackage]:
    """Packages whose sources are in these folders, or near the one in which pytest is started.

    Raises:
        LaunchError: one of the folders is not there.
    """
    folders = [Path(folder) for folder in workspace]
    missing = next((folder for folder in folders if not folder.is_dir()), None)
    if missing is not None:
        raise LaunchError(f"workspace: {missing.absolute()} is not a folder")
    return packages_around(Path("pytest.ini"), [*folders, Path()])


def _neighbourhood(package: Path) -> list[Path]:
    """The folder with the sources of a package's workspace: the nearest one called src, else the one around it."""
    source = next((folder for folder in package.parents if folder.name == "src"), None)
    if source is not None:
        return [source]
    around = package.parent
    # A package alone in a home folder or at the root of a disk has no neighbours that anybody meant.
    return [] if around in (Path(around.root), Path.home()) else [around]


@cache
def sources_in(root: Path) -> tuple[SourcePackage, ...]:
    """The packages below a folder, and the one that it is, in the order of their paths."""
    return tuple(_sources(root, 0))


def _sources(folder: Path, depth: int) -> Iterator[SourcePackage]:
    name = _name(folder / _MANIFEST)
    if name:
        yield SourcePackage(name, folder)
        return  # a package has none in it
    if depth > _DEPTH or any((folder / ignored).exists() for ignored in _IGNORING):
        return
    try:
        below = sorted(entry for entry in folder.iterdir() if entry.is_dir())
    except OSError:
        return
    for entry in below:
        if not entry.name.startswith(".") and entry.name not in _NO_SOURCES:
            yield from _sources(entry, depth + 1)


def _name(manifest: Path) -> str:
    """The name of a package; empty without a readable manifest."""
    try:
        return (ElementTree.parse(manifest).getroot().findtext("name") or "").strip()
    except (OSError, ElementTree.ParseError):
        return ""


@cache
def _scripts(folder: Path) -> dict[str, str]:
    scripts: dict[str, str] = {}
    for read in (_pyproject_scripts, _setup_cfg_scripts, _setup_py_scripts):  # setuptools lets setup.py win
        scripts |= read(folder)
    return scripts


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8")
    except (OSError, ValueError):
        return ""


def _pyproject_scripts(folder: Path) -> dict[str, str]:
    try:
        project = tomllib.loads(_text(folder / "pyproject.toml")).get("project", {})
    except tomllib.TOMLDecodeError:
        return {}
    return dict(project.get("scripts") or project.get("entry-points", {}).get("console_scripts", {}))


def _setup_cfg_scripts(folder: Path) -> dict[str, str]:
    parser = configparser.ConfigParser(interpolation=None)
    try:
        parser.read_string(_text(folder / "setup.cfg"))
    except configparser.Error:
        return {}
    return _parse_entries(parser.get("options.entry_points", "console_scripts", fallback="").splitlines())


def _setup_py_scripts(folder: Path) -> dict[str, str]:
    """The texts below "console_scripts" in a call of `setup`, with the file's constants, without running it."""
    try:
        tree = ast.parse(_text(folder / "setup.py"))
    except SyntaxError:
        return {}
    constants = {
        target.id: statement.value.value
        for statement in ast.walk(tree)
        if isinstance(statement, ast.Assign) and isinstance(statement.value, ast.Constant)
        for target in statement.targets
        if isinstance(target, ast.Name)
    }
    lines: list[str] = []
    for node in ast.walk(tree):
        for key, value in zip(node.keys, node.values, strict=True) if isinstance(node, ast.Dict) else ():
            if isinstance(key, ast.Constant) and key.value == "console_scripts":
                lines += _texts(value, constants)
        for keyword in node.keywords if isinstance(node, ast.Call) else ():
            if keyword.arg == "console_scripts":  # dict(console_scripts=[...])
                lines += _texts(keyword.value, constants)
    return _parse_entries(lines)


def _texts(node: ast.expr, constants: Mapping[str, object]) -> list[str]:
    if isinstance(node, ast.List | ast.Tuple):
        return [text for element in node.elts for text in _texts(element, constants)]
    if isinstance(node, ast.Constant):
        return str(node.value).splitlines()
    if isinstance(node, ast.Name):
        return [str(constants[node.id])] if node.id in constants else []
    if isinstance(node, ast.JoinedStr):
        parts = [part.value if isinstance(part, ast.FormattedValue) else part for part in node.values]
        return ["".join("".join(_texts(part, constants)) for part in parts)]
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        left, right = _texts(node.left, constants), _texts(node.right, constants)
        return [*left, *right] if isinstance(node.left, ast.List) else ["".join([*left, *right])]
    return []


_SCRIPT = re.compile(r"\s*([\w.-]+)\s*=\s*([\w.]+\s*:\s*[\w.]+)")


def _parse_entries(lines: Iterable[str]) -> dict[str, str]:
    matches = [match for line in lines if (match := _SCRIPT.match(line))]
    return {match[1]: match[2].replace(" ", "") for match in matches}


def console_scripts(package: str, sources: Mapping[str, SourcePackage]) -> dict[str, str] | None:
    """The console scripts of a package, as source or installed; None if there is neither."""
    if package in sources:
        return sources[package].scripts
    try:
        scripts = metadata.distribution(package).entry_points.select(group="console_scripts")
    except metadata.PackageNotFoundError:
        return None
    return {script.name: script.value for script in scripts}


def find_executable(package: str, executable: str) -> Path | None:
    """The file that `ros2 run` would start; None if there is none, or no ROS installation."""
    try:
        from ament_index_python import get_package_prefix  # type: ignore[import-not-found, unused-ignore]

        file = Path(get_package_prefix(package)) / "lib" / package / executable
    except (ImportError, LookupError, OSError, ValueError):  # it wants a variable of the environment
        return None
    return file if file.is_file() else None


def find_share(package: str) -> Path | None:
    """The share folder of an installed package; None if there is none, or no ROS installation."""
    try:
        from ament_index_python import get_package_share_directory  # type: ignore[import-not-found, unused-ignore]

        return Path(get_package_share_directory(package))
    except (ImportError, LookupError, OSError, ValueError):  # it wants a variable of the environment
        return None


def is_binary(file: Path) -> bool:
    """Whether a file is a compiled program of Linux (ELF)."""
    with file.open("rb") as content:
        return content.read(4) == b"\x7fELF"


def add_to_index(prefix: Path, packages: Iterable[SourcePackage]) -> None:
    """Make a folder that tells `ament_index_python` of packages what it would know if they were installed.

    Their share folders are links to the sources: files are installed from the same relative path by custom, as
    share/PACKAGE/launch from launch.
    """
    (prefix / _MARKERS).mkdir(parents=True, exist_ok=True)
    shares = {package.name: package.folder for package in packages}
    for name, share in [*shares.items(), *_pip_packages()]:
        if not (prefix / _MARKERS / name).exists():
            (prefix / _MARKERS / name).touch()
            (prefix / "lib" / name).mkdir(parents=True)
            if share.is_dir():
                (prefix / "share" / name).symlink_to(share, target_is_directory=True)


def _pip_packages() -> list[tuple[str, Path]]:
    """Packages of ROS 2 in a virtual environment, which AMENT_PREFIX_PATH lacks, with their share folders."""
    share = Path(sys.prefix) / "share"
    markers = share / "ament_index" / "resource_index" / "packages"
    return [(name, share / name) for name in sorted(os.listdir(markers))] if markers.is_dir() else []
