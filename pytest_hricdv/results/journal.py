"""The journal of a session: an append-only file with its identity and each result, written at once.

`JournalKeeper` appends records by a `JournalWriter`; `read` gives a `Journal`, for `--hri-resume` and
`hricdv report rebuild`. A record is a line: the CRC-32 of its JSON text, its length in bytes, and the text. It is
appended by one write, so the death of the process at any moment costs at most the line that it was writing, which a
reader recognizes. Nothing is flushed to the disk: after a power failure the last lines may be missing or torn, and
their tests run again.

SQLite with a write-ahead log would recover as well. It was not chosen because there is one writer and no query, because
its log needs shared memory and locks that network file systems lack, and because a report folder is copied as an
artifact, at any time: a copy of a growing text is a shorter journal, a copy of three files of a database may be none.
"""

from __future__ import annotations

import contextlib
import errno
import os
import stat
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO
from zlib import compress, crc32  # as now: the code under test may replace them

import msgspec

from pytest_hricdv._base.contained import open_unlinked
from pytest_hricdv._base.descriptors import OWN

NAME = "journal.jsonl"


class StartRecord(msgspec.Struct, frozen=True, tag="began", tag_field="record"):
    """A session began, or continued with this journal: when (UTC), and what its results depend on, name -> value."""

    utc: str
    depends_on: Mapping[str, str]


class SelectionRecord(msgspec.Struct, frozen=True, tag="declared", tag_field="record"):
    """The report as it is before the first result: all that was selected, none of it run."""

    report: msgspec.Raw


class ResultRecord(msgspec.Struct, frozen=True, tag="finished", tag_field="record"):
    """A test has a result; `at_s` is counted from the begin of the session (s of wall time)."""

    nodeid: str
    at_s: float
    result: msgspec.Raw


class NoResultRecord(msgspec.Struct, frozen=True, tag="hindered", tag_field="record"):
    """A test has no result, or one and an error afterwards: why."""

    nodeid: str
    at_s: float
    reason: str


class FeatureRecord(msgspec.Struct, frozen=True, tag="kept", tag_field="record"):
    """A feature's result after the tests, which a resumed session need not compute again.

    `part` is its name, `key` distinguishes its values, and the last one of a key counts.
    """

    part: str
    key: str
    at_s: float
    value: msgspec.Raw


class EndRecord(msgspec.Struct, frozen=True, tag="ended", tag_field="record"):
    """The session ended in an orderly way, and its report is of all that is above; or this was rebuilt.

    `is_whole`: it ran all tests of its suites.
    """

    at_s: float
    is_whole: bool = False


JournalRecord = StartRecord | SelectionRecord | ResultRecord | NoResultRecord | FeatureRecord | EndRecord

_DECODER: msgspec.json.Decoder[JournalRecord] = msgspec.json.Decoder(JournalRecord)
_WRITE = os.write  # as it is now: the code under test may replace it for the whole process
MAX_BYTES = 2_000_000_000
"""Greatest size of a journal: four times that of the largest report, for sessions that continued with it."""

MAX_LINE_BYTES = 200_000_000
"""Greatest size of a line: as of the result of a test that is unpacked. A longer line is not a record, but for instance
zeros, which some file systems leave at the end of a file after a loss of power."""

_BINARY = getattr(os, "O_BINARY", 0)
_FLAGS = os.O_RDWR | os.O_CREAT | _BINARY
"""Windows would translate line ends, so that the lengths in the lines were wrong."""
_BUFFER_BYTES = 1_000_000
"""Read at a time: 2 GB of zeros take 6.9 s of processor time (on a busy machine), and 10.7 s with Python's 8 kB."""
_LONGEST_END = 200
"""Bytes: the line of an `EndRecord` is shorter."""


def line(record: JournalRecord) -> bytes:
    """A record as a line of the file."""
    text = msgspec.json.encode(record)
    return b"%08x %d %s\n" % (crc32(text), len(text), text)


def parse(text: bytes) -> JournalRecord | None:
    """The record of a line; None if it is torn, or was changed."""
    head, _, rest = text.partition(b" ")
    length, _, body = rest.partition(b" ")
    body = body.removesuffix(b"\n")
    if not text.endswith(b"\n") or length != b"%d" % len(body) or head != b"%08x" % crc32(body):
        return None
    try:
        return _DECODER.decode(body)
    except (msgspec.DecodeError, RecursionError):  # written by another version, or by nobody's plugin
        return None


@dataclass
class Journal:
    """The content of a journal.

    Args:
        began: the sessions that wrote it, in order.
        declared: the report without results, as JSON; None if no test had begun.
        results: node id -> result as JSON, compressed; the last one counts.
        reasons: node id -> why it has no result, or what went wrong after it.
        kept: part -> key -> what it worked out after the tests, as JSON, compressed.
        is_ended: whether its last session ended, or its report was rebuilt, and nothing came after.
        is_whole: whether it also ran all tests of its suites.
        wall_s: how long the sessions took, as far as it says.
        earlier_s: the same without the last session.
        damaged: number of torn or changed lines, whose content is missing.
        size: the size of the file up to its last whole line, in bytes.
    """

    began: list[StartRecord] = field(default_factory=list)
    declared: bytes | None = None
    results: dict[str, bytes] = field(default_factory=dict)
    reasons: dict[str, str] = field(default_factory=dict)
    kept: dict[str, dict[str, bytes]] = field(default_factory=dict)
    is_ended: bool = False
    is_whole: bool = False
    wall_s: float = 0.0
    earlier_s: float = 0.0
    damaged: int = 0
    size: int = 0

    @property
    def complete_ids(self) -> frozenset[str]:
        """Node ids of the tests that need not run again."""
        return frozenset(self.results.keys() - self.reasons.keys())

    def add(self, record: JournalRecord) -> None:
        """Take in the next record."""
        self.is_ended = isinstance(record, EndRecord)
        self.is_whole = isinstance(record, EndRecord) and record.is_whole
        match record:
            case StartRecord():
                self.began.append(record)
                self.earlier_s = self.wall_s
            case SelectionRecord(report):
                self.declared = self.declared or bytes(report)
            case ResultRecord(nodeid=nodeid, result=result):
                self.results[nodeid] = compress(bytes(result), 1)
                self.reasons.pop(nodeid, None)
            case NoResultRecord(nodeid=nodeid, reason=reason):
                self.reasons[nodeid] = reason
            case FeatureRecord(part=part, key=key, value=value):
                self.kept.setdefault(part, {})[key] = compress(bytes(value), 1)
        if not isinstance(record, StartRecord | SelectionRecord):
            self.wall_s = self.earlier_s + record.at_s


def read(path: Path) -> Journal:
    """Read a journal. Raises OSError if there is none, or it cannot be read, is a symbolic link, or too large."""
    journal = Journal()
    end = 0
    with _open(path) as file:
        for text, size in _lines(file):
            end += size
            record = parse(text)
            if record is None:
                journal.damaged += 1
            else:
                journal.add(record)
                journal.size = end
    return journal


def _open(path: Path) -> BinaryIO:
    file = open(open_unlinked(path, os.O_RDONLY | _BINARY), "rb", _BUFFER_BYTES)  # noqa: SIM115
    status = os.fstat(file.fileno())
    if stat.S_ISREG(status.st_mode) and status.st_size <= MAX_BYTES:
        return file
    file.close()
    raise OSError(errno.EFBIG, f"no file, or one of more than {MAX_BYTES:,} bytes", str(path))


def _lines(file: BinaryIO) -> Iterator[tuple[bytes, int]]:
    """The lines, and how many bytes each has in the file; a line that is too long is empty."""
    while text := file.readline(MAX_LINE_BYTES):
        size = len(text)
        while len(text) == MAX_LINE_BYTES and not text.endswith(b"\n"):
            text = file.readline(MAX_LINE_BYTES)
            size += len(text)
        yield (text if size == len(text) else b""), size


def records(path: Path) -> list[JournalRecord]:
    """The whole records of a journal, in order. Raises OSError if it cannot be read."""
    with _open(path) as file:
        return [record for text, _ in _lines(file) if (record := parse(text)) is not None]


def is_ended(path: Path) -> bool:
    """Whether the last record of a journal says that its session ended. Raises OSError if it cannot be read."""
    with _open(path) as file:
        file.seek(max(0, file.seek(0, os.SEEK_END) - _LONGEST_END))
        last = file.read().splitlines(keepends=True)[-1:]
    return bool(last) and isinstance(parse(last[0]), EndRecord)


class JournalWriter:
    """Appends records to a journal, whose folder exists.

    What cannot be written, for instance as the disk is full, is kept and written before the next record that can be.

    Args:
        path: the file's path, which is created where it is missing.
        size: appends after this many bytes, which are whole lines; the rest is cut off.

    Raises:
        OSError: the file cannot be opened.
    """

    def __init__(self, path: Path, size: int = 0) -> None:
        self._path = path
        self._size = size
        self._waiting: list[bytes] = []
        self.problem = ""
        """Why records are waiting; empty if none is."""
        self._file = open_unlinked(path, _FLAGS)
        OWN.add(self._file)
        os.ftruncate(self._file, size)

    def append(self, record: JournalRecord) -> None:
        """Append a record; `problem` says whether it could be written."""
        self._waiting.append(line(record))
        try:
            if os.fstat(self._file).st_nlink == 0:
                self._restore()
            while self._waiting:
                self._write(self._waiting[0])
                del self._waiting[0]
            self.problem = ""
        except OSError as error:
            self.problem = f"{self._path}: {error.strerror or error}"

    def _write(self, text: bytes) -> None:
        try:
            os.lseek(self._file, self._size, os.SEEK_SET)
            rest = text
            while rest:
                rest = rest[_WRITE(self._file, rest) :]
        except OSError:
            with contextlib.suppress(OSError):  # a part of a record would hide the next one from readers
                os.ftruncate(self._file, self._size)
            raise
        self._size += len(text)

    def _restore(self) -> None:
        """Writes the file again where it was removed: what was removed can be read as long as it is open."""
        self._path.parent.mkdir(parents=True, exist_ok=True)
        os.lseek(self._file, 0, os.SEEK_SET)
        with open(self._file, "rb") as removed:
            OWN.discard(self._file)
            self._file = open_unlinked(self._path, _FLAGS | os.O_EXCL)
            OWN.add(self._file)
            self._waiting.insert(0, removed.read(self._size))
        self._size = 0

    def close(self) -> None:
        """Close the file."""
        OWN.discard(self._file)
        os.close(self._file)
