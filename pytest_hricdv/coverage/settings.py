"""The project's configuration of coverage.py, which also applies to the coverage measured here.

It is read by coverage.py itself, from the file that it would take (`.coveragerc`, `setup.cfg`, `tox.ini`,
`pyproject.toml`, or the one of `--cov-config`). How things are traced (`parallel`, `concurrency`, `core`, `patch`,
contexts) has no part in this: that is for the user's own measurement only.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from pytest_hricdv.coverage.source_files import CoverageError, ModuleFile

if TYPE_CHECKING:
    import coverage
    from coverage.plugin import FileReporter

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
        with _in_folder(self._folder):
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
            with _in_folder(folder):
                made = coverage.Coverage(data_file=None, config_file=True)
            if made.config.config_file:
                return made, folder
    return made or coverage.Coverage(data_file=None, config_file=False), Path.cwd()


@contextlib.contextmanager
def _in_folder(folder: Path) -> Iterator[None]:
    """coverage.py takes paths of its configuration as relative to the current folder."""
    with contextlib.chdir(folder) if folder != Path.cwd() else contextlib.nullcontext():
        yield
