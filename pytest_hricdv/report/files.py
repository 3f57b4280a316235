"""A report on disk: `report.json` for machines and `index.html` for people, in one folder.

`Preparation` calls `prepare` before the first test; `SessionReporter` and the commands of `hricdv report` then `write`.
"""

import contextlib
import errno
import os
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path

from pytest_hricdv._base import atomic_file
from pytest_hricdv._base.contained import inside
from pytest_hricdv.report.tests_view import FOLDER
from pytest_hricdv.results.codec import REPORT_NAME, ReportError, canonical, load
from pytest_hricdv.results.journal import NAME as JOURNAL_NAME
from pytest_hricdv.results.model import Report

PAGE_NAME = "index.html"
EARLIER = "earlier"
"""The folder inside the report folder to which the report of the session before is moved."""

WHOLE = "whole"
"""The folder inside it that keeps the last report of whole suites while the report of a part of them replaces it."""

_MOVED = (PAGE_NAME, REPORT_NAME, FOLDER, JOURNAL_NAME)
_OTHER_FOLDER = "choose another folder with --hri-report=DIR"
_REMEDIES = {
    errno.ENOSPC: "the disk is full: free some space",
    errno.EDQUOT: "the disk quota is used up: free some space",
    errno.EROFS: f"it is on a read-only file system: {_OTHER_FOLDER}",
    errno.EACCES: f"no permission to write there: change it, or {_OTHER_FOLDER}",
    errno.EPERM: f"no permission to write there: change it, or {_OTHER_FOLDER}",
    errno.ENOTDIR: f"a file is in the way: remove it, or {_OTHER_FOLDER}",
    errno.EEXIST: f"a file is in the way: remove it, or {_OTHER_FOLDER}",
    errno.ELOOP: "a symbolic link is in the way, which is not followed there: remove it",
    errno.EISDIR: f"a folder has the name of a report file: remove it, or {_OTHER_FOLDER}",
}


def prepare(directory: Path) -> None:
    """Create the folder of the report, with its parents, and check that files can be written into it.

    Called before the first test runs: a suite of an hour must not end in "permission denied".

    Raises:
        ReportError: it is not a folder, cannot be written, or the disk is full.
    """
    probe = atomic_file.temporary_path(directory / "probe")
    with explain_write_errors(directory):
        directory.mkdir(parents=True, exist_ok=True)
        try:
            probe.write_bytes(b"\0" * 4096)  # not empty: an empty file fits on a full disk
        finally:
            probe.unlink(missing_ok=True)


def supersede(directory: Path, *, of_this_journal: bool = False) -> bool:
    """Move the report that an earlier session left, with its journal, into the folder `earlier` inside.

    So nothing looks as if it were of the session that begins now, however this ends. Films and replay files stay.

    Args:
        of_this_journal: whether the session continues with the journal, which stays.

    Returns:
        Whether there was anything to move.

    Raises:
        ReportError: a file cannot be moved.
    """
    earlier = directory / EARLIER
    names = [name for name in _MOVED if _is_there(directory / name) and not (of_this_journal and name == JOURNAL_NAME)]
    with explain_write_errors(directory):
        _refuse_links(directory)
        if names and earlier.exists():
            shutil.rmtree(earlier)
        _move(names, directory, earlier)
    return bool(names)


def read_superseded(directory: Path) -> Report | None:
    """The report of the session before; None if there is none, or another version wrote it."""
    for name in (EARLIER, WHOLE):
        try:
            return load(directory / name / REPORT_NAME)
        except ReportError:
            continue
    return None


def keep_whole(directory: Path) -> None:
    """Move the superseded report, which is of whole suites, from `earlier` to `whole`.

    Raises:
        ReportError: it cannot be moved.
    """
    forget_whole(directory)
    with explain_write_errors(directory):
        _refuse_links(directory)
        (directory / EARLIER).rename(directory / WHOLE)


def forget_whole(directory: Path) -> None:
    """Remove the report that was kept in `whole`: there is a newer one of whole suites.

    Raises:
        ReportError: it cannot be removed.
    """
    with explain_write_errors(directory):
        _refuse_links(directory)
        if (directory / WHOLE).exists():
            shutil.rmtree(directory / WHOLE)


def reinstate(directory: Path) -> None:
    """Move the report of the earlier session back: the one that superseded it had no test to run.

    Raises:
        ReportError: a file cannot be moved.
    """
    with explain_write_errors(directory):
        _refuse_links(directory)
        (directory / JOURNAL_NAME).unlink(missing_ok=True)
        _move(_MOVED, directory / EARLIER, directory)
        (directory / EARLIER).rmdir()


def _move(names: Sequence[str], source: Path, target: Path) -> None:
    for name in names:
        if _is_there(source / name):
            target.mkdir(exist_ok=True)
            (source / name).rename(target / name)


def _is_there(path: Path) -> bool:
    """True also for a dangling link, through which a file would be written elsewhere."""
    return os.path.lexists(path)


def _refuse_links(directory: Path) -> None:
    """Raise OSError where a folder for earlier reports is a link: what is in it is removed."""
    for name in (EARLIER, WHOLE):
        inside(directory, f"{name}/{REPORT_NAME}")


def write(report: Report, directory: Path) -> tuple[Path, ...]:
    """Write a report into a folder; returns the files, `report.json` first and the page last.

    Each file is written atomically: a reader sees the old one or the new one, never a part. The results are on disk in
    `report.json` before the page is made from them.

    Raises:
        ReportError: the report holds NaN, the folder cannot be written, or the page cannot be made; then `report.json`
            is written without one.
    """
    written = [write_inside(directory, REPORT_NAME, canonical(report))]
    page, packs = _page(report)
    files = {**packs, PAGE_NAME: page}  # the page last, so that what it loads is there
    written += [write_inside(directory, name, text) for name, text in files.items()]
    _remove_leftovers(directory, written)
    return tuple(written)


def write_inside(directory: Path, name: str, text: str) -> Path:
    """Write a file of a report atomically; returns its path.

    Raises:
        ReportError: the folder cannot be written, or a link in it would lead out of it.
    """
    with explain_write_errors(directory):
        return atomic_file.write_text(inside(directory, name), text)


def write_text(path: Path, text: str) -> Path:
    """Write a file atomically; returns its path.

    Raises:
        ReportError: the folder cannot be written.
    """
    with explain_write_errors(path.parent):
        return atomic_file.write_text(path, text)


def _page(report: Report) -> tuple[str, dict[str, str]]:
    from pytest_hricdv.report import html  # jinja2 is loaded only where a page is made

    try:
        return html.page(report)
    except Exception as error:  # an error in the page must not look as if the results were lost
        cause = f"{type(error).__name__}: {error}"
        raise ReportError(f"{REPORT_NAME} is written, but {PAGE_NAME} could not be made of it: {cause}") from error


def _remove_leftovers(directory: Path, written: Sequence[Path]) -> None:
    """Removes files of tests' details that a larger report left, as far as possible."""
    with contextlib.suppress(OSError):
        inside(directory, f"{FOLDER}/{PAGE_NAME}")
        for path in sorted(set((directory / FOLDER).glob("*.js")) - set(written)):
            path.unlink()
        (directory / FOLDER).rmdir()  # refused as long as anything is in it


@contextlib.contextmanager
def explain_write_errors(directory: Path) -> Iterator[None]:
    """Turn an OSError of a folder that cannot be written into a ReportError that says what to do."""
    try:
        yield
    except OSError as error:
        raise _write_error(directory, error) from error


def _write_error(directory: Path, error: OSError) -> ReportError:
    remedy = _REMEDIES.get(error.errno or 0, f"{error.strerror}: {_OTHER_FOLDER}")
    place = error.filename2 or error.filename or directory
    return ReportError(f"cannot write the report into {directory}: {remedy} ({place})")
