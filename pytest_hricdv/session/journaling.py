"""`JournalKeeper`: writes the session's journal into the report folder, from before the first test to the end.

`Aggregation` makes one and gives it each result; `Preparation` begins the journal, or resumes that of an earlier
session. `results.journal` defines the records in the file.
"""

from __future__ import annotations

import contextlib
import datetime
import time
from collections.abc import Iterator, Mapping, Set
from pathlib import Path
from zlib import decompress  # as now: the code under test may replace it

import msgspec

from pytest_hricdv._base.input_file import MalformedError
from pytest_hricdv._base.project_files import differences
from pytest_hricdv.report import files
from pytest_hricdv.report.formatting import plural
from pytest_hricdv.results.codec import REPORT_NAME, ReportError
from pytest_hricdv.results.folder_files import FolderLock, LockedError
from pytest_hricdv.results.journal import (
    NAME,
    EndRecord,
    FeatureRecord,
    Journal,
    JournalRecord,
    JournalWriter,
    NoResultRecord,
    ResultRecord,
    SelectionRecord,
    StartRecord,
    read,
)
from pytest_hricdv.results.report_builder import content
from pytest_hricdv.session.option import usage_error


class JournalKeeper:
    """Writes the journal. Registered in the controlling process only.

    A journal that cannot be written stops no session: results are in memory as well, and the report is made of them.
    """

    def __init__(self, folder: Path) -> None:
        self.notes: list[str] = []
        """Notes to print before the first test."""
        self.resumed: Journal | None = None
        """The journal of an earlier session that this one resumes."""
        self._folder = folder
        self._depends_on: Mapping[str, str] = {}
        self._lock: FolderLock | None = None
        self._writer: JournalWriter | None = None
        self._began_s = time.monotonic()
        self._declared = False
        self._superseded = False
        self._earlier_is_whole = False

    def lines(self, *, had_header: bool) -> list[str]:
        """The lines to print at the end; the notes from before the first test are repeated only if they were not
        shown."""
        said = [] if had_header else [*self.notes]
        if self.resumed is not None:
            said.append(
                f"resumed: {plural(len(self.resumed.complete_ids), 'test')} done before, with the journal's results"
            )
        if self._writer is not None and self._writer.problem:
            said.append(f"results are missing in the journal: {self._writer.problem}")
        return said

    def begin(self, depends_on: Mapping[str, str], *, resume: bool) -> None:
        """Begin the journal of a session, in a folder that was prepared; an earlier report is moved out of the way.

        Args:
            depends_on: what results depend on, name -> value.
            resume: whether to continue the existing journal, which is touched only when the first test begins.

        Raises:
            pytest.UsageError: another session writes into the folder, the earlier report cannot be moved, or the
                journal to continue with is of something else.
        """
        self._depends_on = depends_on
        with _explain_errors(self._folder):
            self._lock = FolderLock(self._folder)
            earlier = self._earlier()
            if resume and earlier is not None and earlier.declared is not None:
                self._check(earlier)
                self.resumed = earlier
                self.notes.append(_resume_note(earlier))
                return
            if resume:
                self.notes.append(f"hricdv: nothing to resume in {self._folder}: all tests run")
            if earlier is not None and not earlier.is_ended:
                self.notes.append(_interruption_note(earlier, self._folder / files.EARLIER))
                if earlier.results:  # it takes the place of the report in `earlier`
                    self._save_whole()
            if earlier is not None and not earlier.results:  # the report in `earlier` is worth more
                (self._folder / NAME).unlink()
            self._earlier_is_whole = earlier is not None and earlier.is_whole
            self._superseded = files.supersede(self._folder)
            self._open(0)

    def _earlier(self, folder: str = ".") -> Journal | None:
        """The journal of the session before; None if there is none."""
        path = self._folder / folder / NAME
        return read(path) if path.is_file() else None

    def _save_whole(self) -> None:
        """Keep a report of whole suites that a session superseded which was killed before it could keep it."""
        superseded = self._earlier(files.EARLIER)
        if superseded is not None and superseded.is_whole:
            files.keep_whole(self._folder)

    def _check(self, earlier: Journal) -> None:
        differ = differences(earlier.began[0].depends_on if earlier.began else {}, self._depends_on)
        if differ:
            raise usage_error(
                f"--hri-resume: the journal in {self._folder} belongs to another session: {differ}; without "
                "--hri-resume all tests run"
            )
        try:
            content(earlier)
        except ValueError as error:
            raise usage_error(
                f"--hri-resume: the journal in {self._folder} cannot be resumed{_reason(error)}; without "
                "--hri-resume all tests run"
            ) from None

    def _open(self, size: int) -> None:
        self._writer = JournalWriter(self._folder / NAME, size)
        utc = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
        self._writer.append(StartRecord(utc, self._depends_on))

    def declare(self, report: bytes, selected: Set[str]) -> None:
        """Write, once, what is selected; a resumed session continues the journal now.

        Args:
            report: the report without results, as JSON.
            selected: node ids.

        Raises:
            pytest.UsageError: another selection is to be resumed, or the earlier report cannot be moved.
        """
        if self._declared:
            return
        self._declared = True
        if self.resumed is None:
            self._append(SelectionRecord(msgspec.Raw(report)))
            return
        _check_selection(self.resumed, selected)
        with _explain_errors(self._folder):
            self._open(self.resumed.size)
            files.supersede(self._folder, of_this_journal=True)

    def finish(self, nodeid: str, result: str) -> None:
        """Write the result of a test, as JSON."""
        self._append(ResultRecord(nodeid, self._at_s, msgspec.Raw(result.encode())))

    def hinder(self, nodeid: str, reason: str) -> None:
        """Write why a test has no result, or what went wrong after it."""
        self._append(NoResultRecord(nodeid, self._at_s, reason.encode("utf-8", "backslashreplace").decode()))

    def keep(self, part: str, key: str, value: bytes) -> None:
        """Write what an optional part has worked out, as JSON."""
        self._append(FeatureRecord(part, key, self._at_s, msgspec.Raw(value)))

    def read_resumed_value(self, part: str, key: str) -> bytes | None:
        """A value that the resumed session has computed, as JSON; None if it has not."""
        value = None if self.resumed is None else self.resumed.kept.get(part, {}).get(key)
        return None if value is None else decompress(value)

    def keep_whole(self, *, is_whole: bool) -> str:
        """Keep the last report of whole suites next to one of a part of them; a new one of whole suites replaces it.

        Args:
            is_whole: whether this session ran all tests of its suites.

        Returns:
            The page of the report that is kept, relative to the folder; empty if there is none.

        Raises:
            ReportError: files cannot be moved or removed.
        """
        if is_whole:
            files.forget_whole(self._folder)
            return ""
        if self._superseded and self._earlier_is_whole:
            files.keep_whole(self._folder)
        page = f"{files.WHOLE}/{files.PAGE_NAME}"
        return page if (self._folder / page).is_file() else ""

    def end(self, *, is_whole: bool = False) -> None:
        """Write that the session has ended, where its report, if there is anything to report, is in the folder."""
        if not self._declared or (self._folder / REPORT_NAME).is_file():
            self._append(EndRecord(self._at_s, is_whole))

    def _append(self, record: JournalRecord) -> None:
        if self._writer is not None:
            self._writer.append(record)

    def withdraw(self) -> None:
        """The session has no test to run: there will be no report of it, and the earlier one is still the last."""
        if self._writer is not None and self._superseded:
            self._close()
            with contextlib.suppress(ReportError):  # it is in the folder `earlier`
                files.reinstate(self._folder)

    @property
    def _at_s(self) -> float:
        return round(time.monotonic() - self._began_s, 3)

    def abandon(self) -> None:
        """Let another process continue with the journal."""
        self._close()
        if self._lock is not None:
            self._lock.release()
            self._lock = None

    def pytest_unconfigure(self) -> None:
        """Lets others write into the folder."""
        if not self._declared:
            self.end()
        self.abandon()

    def _close(self) -> None:
        if self._writer is not None:
            self._writer.close()
            self._writer = None


@contextlib.contextmanager
def _explain_errors(folder: Path) -> Iterator[None]:
    """Errors of the folder as errors of the option that names it."""
    try:
        yield
    except LockedError as error:
        raise usage_error(
            f"--hri-report={folder}: another session writes its report there ({error}): wait for its end, or choose "
            "another folder"
        ) from None
    except OSError as error:
        raise usage_error(f"--hri-report={folder}: {error.strerror or error}") from None
    except ReportError as error:
        raise usage_error(str(error)) from None


def _since(earlier: Journal) -> str:
    return earlier.began[0].utc if earlier.began else "an unknown time"


def _resume_note(earlier: Journal) -> str:
    torn = f"; {plural(earlier.damaged, 'damaged record')} left out" if earlier.damaged else ""
    done = plural(len(earlier.complete_ids), "test")
    return f"hricdv: resuming the session that began at {_since(earlier)}: {done} done, not run again{torn}"


def _interruption_note(earlier: Journal, moved: Path) -> str:
    began = f"hricdv: the session that began at {_since(earlier)} did not come to its end"
    if not earlier.results:
        return f"{began}, and had no result"
    results = plural(len(earlier.results), "result")
    return (
        f"{began}: its journal, with {results}, is now in {moved}, and --hri-resume would have gone on with it; "
        f"'hricdv report rebuild {moved}' makes its report"
    )


class _Test(msgspec.Struct):
    nodeid: str


class _Selection(msgspec.Struct):
    tests: tuple[_Test, ...]


def _reason(error: ValueError) -> str:
    """Errors of malformed records begin with what follows a file's name; others do not."""
    return str(error) if isinstance(error, MalformedError) else f": {error}"


def _check_selection(earlier: Journal, selected: Set[str]) -> None:
    """Raise pytest.UsageError unless the same tests are selected."""
    before = {test.nodeid for test in msgspec.json.decode(earlier.declared or b"", type=_Selection).tests}
    if before != selected:
        example = min(before ^ selected)
        raise usage_error(
            f"--hri-resume: {len(before)} tests were selected, and {len(selected)} are now; {example} is one of those "
            "that are in one selection only: select the same tests, or run all without --hri-resume"
        )
