"""Rebuilding: the report of a session whose process died, made from its journal."""

from __future__ import annotations

from pathlib import Path

from pytest_hricdv.registry import offers
from pytest_hricdv.report import files
from pytest_hricdv.results.assembling import rebuild
from pytest_hricdv.results.codec import REPORT_NAME, ReportError
from pytest_hricdv.results.folder_lock import FolderLock, LockedError
from pytest_hricdv.results.journal import NAME, Ended, Journal, JournalWriter, read
from pytest_hricdv.results.model import Report


def rebuild_report(folder: Path) -> tuple[Report, str]:
    """Write the report of what the journal in a report folder has; returns it, and what is wrong with it.

    It has neither gates nor what follows the tests (a search, mutants): these need the whole session. Parts add
    what the journal has kept of their work.

    Raises:
        ReportError: there is no journal, its session is running, ended with a report, or had begun no test; or the
            folder cannot be written.
    """
    path = folder / NAME
    if not path.is_file():
        raise ReportError(f"{path}: no such journal; a run with --hri-suite writes one")
    try:
        lock = FolderLock(folder)
    except LockedError as error:
        raise ReportError(f"{folder}: its session is still running ({error}): wait for its end") from None
    except OSError as error:
        raise ReportError(f"{folder}: cannot be written: {error.strerror or error}") from error
    try:
        return _rebuilt(folder, path, read(path))
    except OSError as error:
        raise ReportError(f"{path}: cannot be read: {error.strerror or error}") from error
    finally:
        lock.release()


def _rebuilt(folder: Path, path: Path, journal: Journal) -> tuple[Report, str]:
    if journal.is_ended and (folder / REPORT_NAME).is_file():
        raise ReportError(f"{folder}: the session ended, and {REPORT_NAME} has all its results: nothing to rebuild")
    try:
        report, problem = rebuild(journal)
    except ValueError as error:
        raise ReportError(f"{path}: no report can be made of it: {error}; run the suite again") from None
    for of_part in offers("merging", "rebuilt"):
        report = of_part(report, journal.kept)
    files.write(report, folder)
    writer = JournalWriter(path, journal.size)
    writer.append(Ended(journal.wall_s - journal.earlier_s))
    writer.close()
    return report, problem
