"""Finds the source files of the code under test as Python would, but without importing anything."""

from __future__ import annotations

import importlib.util
import os
import re
import sys
import zipfile
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from importlib.machinery import EXTENSION_SUFFIXES, ModuleSpec
from pathlib import Path, PurePosixPath

from pytest_hricdv._base.message import InputError

SOURCE = re.compile(r"[^.#~!$@%^&*()+=,]+\.py")
"""Names of files that coverage.py takes for modules; others are what editors leave behind."""

INSTALLED = frozenset({"site-packages", "dist-packages"})


class CoverageError(InputError):
    """The code under test cannot be measured as asked; the text says where and what to do."""


@dataclass(frozen=True)
class ModuleFile:
    """A module's file.

    Args:
        path: of the file; within an archive, of the archive and on.
        name: as reports show it.
        module: as Python calls it.
        problem: why there is no source to measure; empty if there is.
    """

    path: Path
    name: str
    module: str
    problem: str = ""


@dataclass(frozen=True)
class _SourceLocation:
    place: Path
    within: PurePosixPath
    """Where it is below the folder that is searched for modules."""


def module_files(packages: Iterable[str], root: Path) -> tuple[ModuleFile, ...]:
    """The files of packages and modules, sorted by path.

    A folder without `__init__.py` is a namespace package, as for Python, if its name can stand in an import statement.

    Args:
        packages: importable names.
        root: the folder that names of files are relative to, where they lie below it. Those of installed packages are
            relative to where their package is installed.

    Raises:
        CoverageError: a package that is not there.
    """
    located = {_real(file.place): file for package in packages for file in _files(package)}
    names = {path: _show(path, file, root) for path, file in located.items()}
    several = {name for name in names.values() if [*names.values()].count(name) > 1} if _repeat(names.values()) else ()
    return tuple(
        ModuleFile(
            path,
            path.as_posix() if names[path] in several else names[path],
            _module(located[path].within),
            _problem(path),
        )
        for path in sorted(located)
    )


def _repeat(names: Iterable[str]) -> bool:
    listed = list(names)
    return len(set(listed)) < len(listed)


def _real(path: Path) -> Path:
    return path.resolve()


def _show(path: Path, file: _SourceLocation, root: Path) -> str:
    for folder in (root, root.resolve()):
        if path.is_relative_to(folder) and INSTALLED.isdisjoint(path.relative_to(folder).parts):
            return path.relative_to(folder).as_posix()
    return str(file.within)


def _module(within: PurePosixPath) -> str:
    parts = [*within.parts[:-1], within.name.partition(".")[0]]
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _problem(path: Path) -> str:
    if path.suffix == ".pyc":
        return "it has no source: only the compiled file is there"
    return "" if path.suffix == ".py" else "it is an extension module, and has no source in Python"


def _files(package: str) -> Iterator[_SourceLocation]:
    spec = find_without_importing(package)
    if spec is None:
        raise CoverageError(
            f"code under test: there is no package or module {package!r}; name one that can be imported"
        )
    above = PurePosixPath(*package.split(".")[:-1])
    if spec.submodule_search_locations is None:
        if not spec.has_location or spec.origin is None:
            raise CoverageError(f"code under test: {package!r} is built into Python, and has no file to measure")
        yield _SourceLocation(Path(spec.origin), above / Path(spec.origin).name)
        return
    for location in spec.submodule_search_locations:
        folder, within = Path(location), above / package.rpartition(".")[2]
        yield from _in_folder(folder, within) if folder.is_dir() else _in_archive(folder, within)


def find_without_importing(name: str) -> ModuleSpec | None:
    """The spec of a module; `importlib.util.find_spec` would import the packages that it is in."""
    top, *parts = name.split(".")
    try:
        spec = importlib.util.find_spec(top) if top else None
    except ImportError as error:  # of a finder, which looks for it in a way of its own
        raise CoverageError(f"code under test: {top!r} cannot be found: {error}") from error
    except ValueError:  # it is loaded, and has no spec, as what stands in for a module
        return None
    full = top
    for part in parts:
        if spec is None or spec.submodule_search_locations is None or not part:
            return None
        full, path = f"{full}.{part}", [*spec.submodule_search_locations]
        spec = _in_package(full, path)
    return spec


def _in_package(full: str, path: list[str]) -> ModuleSpec | None:
    finders = (finder for finder in sys.meta_path if hasattr(finder, "find_spec"))
    try:
        spec: ModuleSpec | None = next(filter(None, (finder.find_spec(full, path) for finder in finders)), None)
        return spec if spec is None or [*(spec.submodule_search_locations or ("",))] else None
    except KeyError:  # a namespace package within a package wants that one to be imported
        folders = [folder for place in path if (folder := Path(place) / full.rpartition(".")[2]).is_dir()]
        spec = ModuleSpec(full, None, is_package=True)
        spec.submodule_search_locations = [*map(str, folders)]
        return spec


def _in_folder(folder: Path, within: PurePosixPath, above: Sequence[Path] = ()) -> Iterator[_SourceLocation]:
    if folder.resolve() in above:  # a link that leads back
        return
    entries = sorted(os.scandir(folder), key=lambda entry: entry.name)
    for entry in entries:
        path = Path(entry.path)
        if entry.is_dir():
            if (entry.name.isidentifier() and entry.name != "__pycache__") or (path / "__init__.py").is_file():
                yield from _in_folder(path, within / entry.name, (*above, folder.resolve()))
        elif SOURCE.fullmatch(entry.name) or _is_without_source(path):
            yield _SourceLocation(path, within / entry.name)


def _is_without_source(path: Path) -> bool:
    if path.suffix == ".pyc":
        return not path.with_suffix(".py").exists()
    return path.name.endswith(tuple(EXTENSION_SUFFIXES))


def _in_archive(folder: Path, within: PurePosixPath) -> Iterator[_SourceLocation]:
    archive = next((path for path in folder.parents if path.is_file()), None)
    if archive is None or not zipfile.is_zipfile(archive):
        return
    inner = PurePosixPath(folder.relative_to(archive).as_posix())
    with zipfile.ZipFile(archive) as opened:
        names = sorted(map(PurePosixPath, opened.namelist()))
    for name in names:
        if name.is_relative_to(inner) and SOURCE.fullmatch(name.name):
            yield _SourceLocation(archive / name, within / name.relative_to(inner))
