"""A report on disk: `report.json` for machines and `index.html` for people, in one folder."""

import contextlib
import errno
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pytest_hricdv.report.contract import SCHEMA, faults

REPORT_NAME = "report.json"
PAGE_NAME = "index.html"

_REMEDIES = {
    errno.ENOSPC: "the disk is full: free some space",
    errno.EDQUOT: "the disk quota is used up: free some space",
    errno.EROFS: "it is on a read-only file system: choose another folder with --hri-report=DIR",
    errno.EACCES: "no permission to write there: change it, or choose another folder with --hri-report=DIR",
    errno.EPERM: "no permission to write there: change it, or choose another folder with --hri-report=DIR",
    errno.ENOTDIR: "a file is in the way: remove it, or choose another folder with --hri-report=DIR",
    errno.EEXIST: "a file is in the way: remove it, or choose another folder with --hri-report=DIR",
    errno.EISDIR: "a folder has the name of a report file: remove it, or choose another folder with --hri-report=DIR",
}


class ReportError(Exception):
    """A report cannot be written or read; the message says which file, why, and what to do."""


def prepare(directory: Path) -> None:
    """Create the folder of the report, with its parents, and check that files can be written into it.

    Called before the first test runs: a suite of an hour must not end in "permission denied".

    Raises:
        ReportError: it is no folder, cannot be written, or the disk is full.
    """
    probe = _aside(directory / "probe")
    try:
        directory.mkdir(parents=True, exist_ok=True)
        try:
            probe.write_bytes(b"\0" * 4096)  # more than nothing: an empty file fits on a full disk
        finally:
            probe.unlink(missing_ok=True)
    except OSError as error:
        raise _refused(directory, error) from error


def write(report: Mapping[str, Any], directory: Path) -> tuple[Path, ...]:
    """Write a report into a folder; returns the files, `report.json` first.

    Both files are written aside and then renamed, so a reader sees the old report or the new one, never a part.

    Raises:
        ReportError: the report breaks its contract (NaN included), or the folder cannot be written.
    """
    from pytest_hricdv.report.html import render  # jinja2 is loaded only where a page is made

    broken = faults(report)
    if broken:
        raise ReportError(f"cannot write a report that breaks {SCHEMA}: {_first(broken)}")
    contents = {REPORT_NAME: canonical(report), PAGE_NAME: render(report)}
    paths = tuple(directory / name for name in contents)
    try:
        for path, text in zip(paths, contents.values(), strict=True):
            # A lone surrogate in a name has no UTF-8: show its number rather than lose the report.
            _aside(path).write_bytes(text.encode("utf-8", "backslashreplace"))
        for path in paths:
            _aside(path).replace(path)
    except OSError as error:
        raise _refused(directory, error) from error
    finally:
        for path in paths:
            with contextlib.suppress(OSError):
                _aside(path).unlink(missing_ok=True)
    return paths


def canonical(report: Mapping[str, Any]) -> str:
    """The report as JSON text that depends on its content only: sorted keys, ASCII, one value a line.

    Raises:
        ReportError: a value has no JSON, such as NaN or a set.
    """
    try:
        return json.dumps(report, sort_keys=True, indent=1, allow_nan=False) + "\n"
    except (TypeError, ValueError) as error:
        raise ReportError(f"cannot write the report as JSON: {error}") from error


def load(path: Path) -> dict[str, Any]:
    """Read a report: a `report.json`, or the folder that holds one.

    Raises:
        ReportError: with the file and the place in it, where it is missing, cut off, of another schema, or incomplete.
    """
    file = path / REPORT_NAME if path.is_dir() else path
    try:
        text = file.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise ReportError(f"{file}: no such report; a run with --hri-suite writes one") from None
    except (OSError, UnicodeDecodeError) as error:
        raise ReportError(f"{file}: cannot be read: {error}") from error
    try:
        report = json.loads(text)
    except json.JSONDecodeError as error:
        message = f"{file}:{error.lineno}:{error.colno}: not JSON, perhaps cut off ({error.msg}); run the suite again"
        raise ReportError(message) from error
    found = report.get("schema") if isinstance(report, dict) else None
    if found != SCHEMA:
        raise ReportError(
            f"{file}: expected schema {SCHEMA!r}, found {found!r}; use the plugin's version that wrote it"
        )
    broken = faults(report)
    if broken:
        raise ReportError(f"{file}: {_first(broken)}")
    loaded: dict[str, Any] = report
    return loaded


def _aside(path: Path) -> Path:
    """Where a file is written before it is renamed: the same folder, or the rename would not be atomic."""
    return path.with_name(f".{path.name}.{os.getpid()}.part")


def _refused(directory: Path, error: OSError) -> ReportError:
    remedy = _REMEDIES.get(error.errno or 0, f"{error.strerror}: choose another folder with --hri-report=DIR")
    place = error.filename2 or error.filename or directory
    return ReportError(f"cannot write the report into {directory}: {remedy} ({place})")


def _first(broken: list[str]) -> str:
    more = f" (and {len(broken) - 1} more)" if len(broken) > 1 else ""
    return f"{broken[0]}{more}"
