"""`StoredRun`: a run in a file, with all messages and signals, so that new requirements can be judged on it.

The process that records runs makes it with `store` and saves it with `write`; `read` is for `Recordings`.
"""

from __future__ import annotations

import zlib
from array import array
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import msgspec

from pytest_hricdv._base.atomic_file import write_bytes
from pytest_hricdv.execution.case import CaseResult
from pytest_hricdv.execution.faults import CodeUnderTest
from pytest_hricdv.monitor import Log
from pytest_hricdv.runtime.record import Value

Series = tuple[bytes, bytes]
Texts = tuple[bytes, list[str]]
"""The times (s) and values of a numeric (`Series`) or string signal; numbers are stored as the bytes of doubles."""


class StoredMessage(msgspec.Struct, frozen=True, array_like=True):
    """A message: when (s), who sent it, its topic and fields."""

    time_s: float
    sender: str
    topic: str
    fields: dict[str, bool | int | float | str]


class StoredRun(msgspec.Struct, frozen=True, kw_only=True):
    """One run of a test.

    Args:
        sha256: SHA-256 of the record; empty if there is none.
        end_s: when it ended (s of simulated time).
        failed: the requirements that it violated, except known violations.
        errors: what else was wrong with it, a sentence each.
        signals: name -> series, of numeric and bool signals.
        texts: name -> texts, of string signals.
        messages: the messages, in the order of time.
        own_topics: the topics that the code under test has sent.
        own_signals: the signals that only the code under test has changed, at work itself.
        other_signals: the signals that only nodes have changed that are not code under test, such as a person.
    """

    test: str
    sha256: str = ""
    end_s: float = 0.0
    failed: tuple[str, ...] = ()
    errors: tuple[str, ...] = ()
    signals: dict[str, Series] = {}
    texts: dict[str, Texts] = {}
    messages: tuple[StoredMessage, ...] = ()
    own_topics: tuple[str, ...] = ()
    own_signals: tuple[str, ...] = ()
    other_signals: tuple[str, ...] = ()

    @property
    def has_record(self) -> bool:
        """Whether there is something to judge."""
        return bool(self.sha256)

    def log(self) -> Log:
        """What monitors judge."""
        signals = {name: (_doubles(times), _doubles(values)) for name, (times, values) in self.signals.items()}
        texts = {name: (_doubles(times), values) for name, (times, values) in self.texts.items()}
        return Log({**signals, **texts}, self.messages, self.end_s)


def _doubles(data: bytes) -> array[float]:
    return array("d", data)


@dataclass
class Authorship:
    """A watcher of a run that notes who sent which topics and changed which signals: the code under test, other nodes
    such as a person, or the world.
    """

    code: CodeUnderTest | None = None
    topics: set[str] = field(default_factory=set)
    changed_by: dict[str, set[str]] = field(default_factory=dict)

    def begin(self, code: CodeUnderTest) -> None:
        """Called before the run."""
        self.code = code

    def message(self, time_s: float, topic: str, fields: Mapping[str, Value]) -> None:
        """See `monitor.MonitorSet`."""
        if self.code is not None and self.code.is_running():
            self.topics.add(topic)

    def signal(self, time_s: float, name: str, value: Value) -> None:
        """See `monitor.MonitorSet`. A signal's first value is not a change."""
        authors = self.changed_by.get(name)
        if authors is None or self.code is None:
            self.changed_by[name] = set()
        else:
            authors.add("code" if self.code.is_running() else "other" if self.code.is_other_running() else "world")

    def signals_of(self, author: str) -> tuple[str, ...]:
        """The signals that no other one has changed."""
        return tuple(sorted(name for name, authors in self.changed_by.items() if authors == {author}))


def store(test: str, result: CaseResult, authorship: Authorship, failed: tuple[str, ...]) -> StoredRun:
    """What is stored of a run.

    Args:
        authorship: watched it.
        failed: the requirements that it violated, except known violations.
    """
    return StoredRun(
        test=test,
        sha256=result.record.sha256,
        end_s=result.sim_s,
        failed=failed,
        errors=result.errors,
        signals={name: (times.tobytes(), values.tobytes()) for name, (times, values) in result.record.signals.items()},
        texts={name: (times.tobytes(), list(values)) for name, (times, values) in result.record.texts.items()},
        messages=tuple(
            StoredMessage(message.time_s, message.sender, message.topic, dict(message.fields))
            for message in result.record.messages
            if not message.is_disturbance
        ),
        own_topics=tuple(sorted(authorship.topics)),
        own_signals=authorship.signals_of("code"),
        other_signals=authorship.signals_of("other"),
    )


_DECODER = msgspec.msgpack.Decoder(StoredRun)


def write(path: Path, run: StoredRun) -> None:
    """Store a run; the file is there whole or not at all."""
    write_bytes(path, zlib.compress(msgspec.msgpack.encode(run), 1))


def read(path: Path) -> StoredRun | None:
    """The run of a file; None if there is none, or another version has written it."""
    try:
        return _DECODER.decode(zlib.decompress(path.read_bytes()))
    except (OSError, zlib.error, msgspec.DecodeError):
        return None
