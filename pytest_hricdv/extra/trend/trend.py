"""The history of sessions that `--hri-history` keeps."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from msgspec.structs import replace

from pytest_hricdv._base.input_file import MalformedError
from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.trend import records as history
from pytest_hricdv.extra.trend.entry import entry_of
from pytest_hricdv.results.model import Report


@dataclass(frozen=True)
class Noted:
    """The report with its history, and what is to be said of the file, a sentence each."""

    report: Report
    warnings: tuple[str, ...] = ()
    problem: str = ""


def noted(report: Report, path: Path, *, is_whole: bool) -> Noted:
    """Add a session to the history, and earlier ones of the same suites and options to its report.

    Args:
        report: of the session, with its origin.
        path: of the history, which is created where it is missing.
        is_whole: all tests of the suites ran: others are kept in the file, and compared with nothing.
    """
    entry = entry_of(report, is_whole=is_whole)
    try:
        earlier, damaged = history.read(path)
        history.append(path, entry)
    except (OSError, MalformedError) as error:
        what = error.strerror or error if isinstance(error, OSError) else error
        return Noted(report, problem=visible(f"--hri-history: {path}: {what}"))
    warnings = tuple(f"{path}:{number}: no session of a history; it was left out" for number in damaged)
    entries = (*history.comparable(earlier, entry), entry) if is_whole else ()
    return Noted(replace(report, history=entries), warnings)
