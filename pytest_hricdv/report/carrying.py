"""`FileCarrier`: copies the files of reports, such as films, into the merged one's folder (`hricdv report merge`)."""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from hashlib import file_digest, sha256
from pathlib import Path

from msgspec.structs import replace

from pytest_hricdv._base import atomic_file
from pytest_hricdv._base.contained import files_inside, inside
from pytest_hricdv.report.files import explain_write_errors
from pytest_hricdv.results.codec import ReportError
from pytest_hricdv.results.model import Report, TestResult
from pytest_hricdv.results.section import report_sections, test_sections

REPLAYS = "failures"
"""The folder of replay files inside of a report; features have folders of their own."""

_REPLAY_SUFFIXES = (".json",)
_MAX_BYTES = 2_000_000_000
"""Greatest size of a file that is copied (bytes). Chosen: larger than a film or a trace of an hour. The limit is for
sparse files, which may have any size."""


@dataclass
class FileCarrier:
    """The files of several reports, to be copied into the folder of another one.

    Where files with one name differ, as of two runs of one test that differ, all of them get names with a hash: so the
    names do not depend on the order of the reports.

    Args:
        sources: folders of the reports that have the files.
        target: folder of the report that is to have them.

    Raises:
        ReportError: a file cannot be read, or is a symbolic link: what that leads to is not part of a report.
    """

    sources: Iterable[Path]
    target: Path
    _hashes: dict[str, set[str]] = field(default_factory=dict)
    """Folder and name -> hashes of the files that have it."""

    def __post_init__(self) -> None:
        try:
            for path in self._files():
                self._hashes.setdefault(f"{path.parent.name}/{path.name}", set()).add(_hash(path))
        except OSError as error:
            raise ReportError(
                f"{error.filename or 'a report'}: {error.strerror or error}; nothing was merged"
            ) from None

    def _files(self) -> Iterator[Path]:
        folders = {section.folder: section.suffixes for section in test_sections() if section.folder}
        for source in self.sources:
            for name, suffixes in {REPLAYS: _REPLAY_SUFFIXES, **folders}.items():
                for path in files_inside(source, name, suffixes):
                    if path.stat().st_size > _MAX_BYTES:
                        raise OSError(errno.EFBIG, f"too large; expected at most {_MAX_BYTES:,} bytes", str(path))
                    yield path

    def rename_files(self, report: Report, source: Path) -> Report:
        """A report with the names that its files will have."""
        names = _NewNames(self, source)
        report = replace(report, tests=tuple(map(names.of_test, report.tests)))
        for section in report_sections():
            if section.rename is not None:
                report = section.put(report, section.rename(section.of(report), names))
        return report

    def copy(self) -> None:
        """Copy the files.

        Raises:
            ReportError: the folder cannot be written.
        """
        with explain_write_errors(self.target):
            for path in self._files():
                target = inside(self.target, self.name(path))
                if not target.is_file() or target.is_symlink():
                    with atomic_file.replace_file(target) as part:
                        shutil.copyfile(path, part)

    def name(self, path: Path) -> str:
        """The name of a file, relative to the target."""
        name = f"{path.parent.name}/{path.name}"
        if len(self._hashes[name]) == 1:
            return name
        return f"{path.parent.name}/{path.stem}-{_hash(path)}{path.suffix}"


@dataclass(frozen=True)
class _NewNames:
    """Changes the names in one report, whose files are in `source`; a file that is missing keeps its name."""

    carrying: FileCarrier
    source: Path

    def of_test(self, test: TestResult) -> TestResult:
        for section in test_sections():
            if section.rename is not None:
                test = section.put(test, section.rename(section.of(test), self))
        return replace(
            test,
            replay=self.replay(test.replay),
            repeats=tuple(map(self.of_test, test.repeats)),
        )

    def replay(self, name: str | None) -> str | None:
        """The path of a replay file as given to pytest: relative to the folder where pytest starts."""
        path = self.source / REPLAYS / Path(name or "").name
        return os.path.relpath(self.carrying.target / self.carrying.name(path)) if name and path.is_file() else name

    def file(self, folder: str, name: str | None) -> str | None:
        """The path of a file in a folder, relative to the report."""
        path = self.source / folder / Path(name or "").name
        return self.carrying.name(path) if name and path.is_file() else name


def _hash(path: Path) -> str:
    with path.open("rb") as file:
        return file_digest(file, sha256).hexdigest()[:8]
