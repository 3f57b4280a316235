"""A report on disk: `report.json` for machines and `index.html` for people, in one folder."""

import contextlib
import errno
import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pytest_hricdv.report.contract import SCHEMA, faults

REPORT_NAME = "report.json"
PAGE_NAME = "index.html"
DETAILS = "details"
"""The folder beside the page that holds the tests' details of a large report."""

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
    """Write a report into a folder; returns the files, `report.json` first and the page last.

    Each file is written aside and then renamed, so a reader sees the old one or the new one, never a part. What a run
    found out is safe in `report.json` before the page is made of it.

    Raises:
        ReportError: the report breaks its contract (NaN included), the folder cannot be written, or no page can be made
            of the report, which is then written without one.
    """
    broken = faults(report)
    if broken:
        raise ReportError(f"cannot write a report that breaks {SCHEMA}: {_first(broken)}")
    written = [write_text(directory / REPORT_NAME, canonical(report))]
    written += [write_text(directory / name, text) for name, text in _pages(report).items()]
    _drop_leftovers(directory, written)
    return tuple(written)


def _pages(report: Mapping[str, Any]) -> dict[str, str]:
    from pytest_hricdv.report.html import pages  # jinja2 is loaded only where a page is made

    try:
        return pages(report)
    except Exception as error:  # whatever is wrong with the page must not look as if the run had been lost
        what = f"{type(error).__name__}: {error}"
        raise ReportError(f"{REPORT_NAME} is written, but {PAGE_NAME} could not be made of it: {what}") from error


def _drop_leftovers(directory: Path, written: Sequence[Path]) -> None:
    """Removes what a larger report left of its tests' details, so far as that can be done."""
    with contextlib.suppress(OSError):
        for path in sorted(set((directory / DETAILS).glob("*.js")) - set(written)):
            path.unlink()
        (directory / DETAILS).rmdir()  # refused as long as anything is in it


def write_text(path: Path, text: str) -> Path:
    """Write a file aside and rename it.

    Raises:
        ReportError: the folder cannot be written.
    """
    aside = _aside(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # A lone surrogate in a name has no UTF-8: show its number rather than lose the report.
        aside.write_bytes(text.encode("utf-8", "backslashreplace"))
        aside.replace(path)
    except OSError as error:
        raise _refused(path.parent, error) from error
    finally:
        with contextlib.suppress(OSError):
            aside.unlink(missing_ok=True)
    return path


def canonical(report: Mapping[str, Any]) -> str:
    """The report as JSON text that depends on its content only: sorted keys, ASCII, a line for each key and, of lists,
    for each item. (With a line for each value, thousands of tests would take five times as long.)

    Raises:
        ReportError: a value has no JSON, such as NaN or a set.
    """
    try:
        lines = [f"{_compact(key)}: {_itemized(report[key])}" for key in sorted(report)]
    except (TypeError, ValueError) as error:
        raise ReportError(f"cannot write the report as JSON: {error}") from error
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _itemized(value: object) -> str:
    if not isinstance(value, list) or not value:
        return _compact(value)
    return "[\n" + ",\n".join(map(_compact, value)) + "\n]"


def _compact(value: object) -> str:
    return json.dumps(value, sort_keys=True, allow_nan=False)


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
