"""`module_files` finds the source files of the code under test as Python would, without importing any.

`map_code` calls it once per session, and leaves out what coverage.py's configuration leaves out (`CoverageSettings`).
coverage.py itself reads this, from the file that it would take (`.coveragerc`, `setup.cfg`, `tox.ini`,
`pyproject.toml`, or the one of `--cov-config`). How things are traced (`parallel`, `concurrency`, `core`, `patch`,
contexts) is for the user's own measurement only.
"""

from __future__ import annotations

import contextlib
import importlib.util
import os
import re
import sys
import zipfile
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from importlib.machinery import EXTENSION_SUFFIXES, ModuleSpec
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

from pytest_hricdv._base.message import InputError

if TYPE_CHECKING:
    import coverage
    from coverage.plugin import FileReporter

SOURCE = re.compile(r"[^.#~!$@%^&*()+=,]+\.py")
"""Names of files that coverage.py takes for modules; others are what editors leave behind."""

INSTALLED = frozenset({"site-packages", "dist-packages"})
"""Names of folders with installed packages."""


class CoverageError(InputError):
    """The code under test cannot be measured as asked; the message says where and what to do."""


@dataclass(frozen=True)
class ModuleFile:
    """A module's file.

    Args:
        path: the file's path; of a file in an archive, the path of the archive and the path in it.
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


_FILES = (".coveragerc", ".coveragerc.toml", "setup.cfg", "tox.ini", "pyproject.toml")


class CoverageSettings:
    """The settings of what coverage.py counts.

    Args:
        folders: where the configuration is looked for, in this order; None: it does not matter what any file says.
        file: the file that the user names; empty where he does not.

    Raises:
        CoverageError: a configuration that coverage.py does not take.
    """

    def __init__(self, folders: Sequence[Path] | None = None, file: str = "") -> None:
        from coverage.exceptions import CoverageException

        try:
            self._coverage, self._folder = _read(folders, file)
            self._coverage.get_exclude_list()  # this loads plugins, which may change the configuration
        except CoverageException as error:
            raise CoverageError(f"the configuration of coverage.py: {error}") from None
        self.file: str = self._coverage.config.config_file or ""

    def reporter(self, path: Path) -> FileReporter:
        """The analysis of a file by coverage.py: statements, arcs, exclusions."""
        from coverage.python import PythonFileReporter

        return PythonFileReporter(str(path), self._coverage)

    def is_measured(self, file: ModuleFile) -> bool:
        """Whether coverage.py would measure a file and report it: `source`, `include` and `omit`."""
        from coverage.files import GlobMatcher, ModuleMatcher, TreeMatcher, canonical_filename, prep_patterns

        config, path = self._coverage.config, str(file.path)
        with _in_current_folder(self._folder):
            folders, packages = [*config.source_dirs], [*config.source_pkgs]
            for source in config.source or ():
                (folders if os.path.isdir(source) else packages).append(source)
            if folders or packages:
                is_of_source = TreeMatcher([canonical_filename(folder) for folder in folders]).match(path)
                if not is_of_source and not ModuleMatcher(packages).match(file.module):
                    return False
            elif config.run_include and not GlobMatcher(prep_patterns(config.run_include)).match(path):
                return False
            if config.report_include and not GlobMatcher(prep_patterns(config.report_include)).match(path):
                return False
            omitted = prep_patterns([*(config.run_omit or ()), *(config.report_omit or ())])
            return not (omitted and GlobMatcher(omitted).match(path))


def _read(folders: Sequence[Path] | None, file: str) -> tuple[coverage.Coverage, Path]:
    import coverage

    if folders is None:
        return coverage.Coverage(data_file=None, config_file=False), Path.cwd()
    if (file and file != ".coveragerc") or os.environ.get("COVERAGE_RCFILE"):
        return coverage.Coverage(data_file=None, config_file=file or True), Path.cwd()
    made = None
    for folder in dict.fromkeys(folders):
        if any((folder / name).is_file() for name in _FILES):
            with _in_current_folder(folder):
                made = coverage.Coverage(data_file=None, config_file=True)
            if made.config.config_file:
                return made, folder
    return made or coverage.Coverage(data_file=None, config_file=False), Path.cwd()


@contextlib.contextmanager
def _in_current_folder(folder: Path) -> Iterator[None]:
    """coverage.py takes paths of its configuration as relative to the current folder."""
    with contextlib.chdir(folder) if folder != Path.cwd() else contextlib.nullcontext():
        yield
