"""The store of a campaign: an SQLite file with one row for each run, written as soon as the run arrives.

The commands open it with `Store.open`; `Execution` writes runs into it. A write-ahead log lets `status` and `report`
read while a campaign writes, and needs a file system with locks and shared memory, such as a local one. Sessions have
fewer tests and no queries, so their journal is a text file (`results.journal`).
"""

from __future__ import annotations

import json
import sqlite3
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import msgspec

from pytest_hricdv._base.input_file import MAX_REPORT_BYTES, unpack
from pytest_hricdv.extra.campaign.database import (
    LOST,
    TABLES,
    Row,
    RowSummary,
    check_keys,
    check_tables,
    connect,
    error_location,
    read_row,
)
from pytest_hricdv.extra.campaign.plan import CampaignError, CampaignPlan, RunKey
from pytest_hricdv.results.codec import check_report, encode
from pytest_hricdv.results.folder_files import FolderLock, LockedError
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.session.remote import WorkerName

SCHEMA = "hricdv-campaign/4"


class Repeat(msgspec.Struct, frozen=True, array_like=True):
    """A run that another worker repeated: its record hash there, and the first difference of the two records."""

    test: int
    k: int
    sha256: str
    worker: int
    parting: str

    @property
    def key(self) -> RunKey:
        """The run that was repeated."""
        return self.test, self.k


@dataclass(frozen=True)
class Counts:
    """The progress of a campaign: runs by outcome, their times (s), and how many were repeated and differ."""

    outcomes: Mapping[str, int]
    sim_s: float
    wall_s: float
    repeated: int
    differing: int

    @property
    def runs(self) -> int:
        """Runs that have an outcome."""
        return sum(self.outcomes.values())


class Store:
    """A campaign's file. Made by `create` or `open`.

    All methods raise CampaignError where the file is damaged or cannot be written.
    """

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        self.path = path
        self._connection = connection
        self._lock: FolderLock | None = None

    @classmethod
    def create(cls, path: Path, plan: CampaignPlan) -> Self:
        """A new store. Raises CampaignError if there is a file already."""
        if path.exists():
            raise CampaignError(f"{path}: there is such a file already")
        if not path.parent.is_dir():
            raise CampaignError(f"{path}: there is no folder {path.parent}")
        with error_location(path):
            store = cls(path, connect(path))
            with store._connection:
                store._connection.executescript(TABLES)
                store._put("schema", SCHEMA.encode())
                store._put("plan", zlib.compress(plan.to_json()))
        return store

    @classmethod
    def open(cls, path: Path) -> Self:
        """The store in a file. Raises CampaignError if there is none."""
        if not path.is_file():
            raise CampaignError(f"{path}: no such campaign: 'hricdv campaign run --state={path}' begins one")
        with error_location(path):
            store = cls(path, connect(path))
            schema = store._schema()
            if schema != SCHEMA.encode():
                raise CampaignError(f"{path}: expected a campaign of schema {SCHEMA}, found {schema!r}")
            check_tables(path, store._connection)
            # Reads the largest table: a file that was cut off is noticed here, and not in the middle of a report.
            store._connection.execute("SELECT count(*) FROM results WHERE test < 0").fetchone()
        return store

    def hold(self) -> None:
        """Keep others from running this campaign. Raises CampaignError if somebody does."""
        try:
            self._lock = FolderLock(self.path.parent, f"{self.path.name}.lock")
        except LockedError as error:
            raise CampaignError(f"{self.path}: this campaign is running already ({error})") from None
        except OSError as error:
            raise CampaignError(f"{self.path}: {error.strerror}") from None

    def close(self) -> None:
        """Close the file."""
        with suppress(sqlite3.Error):
            self._connection.close()
        if self._lock is not None:
            self._lock.release()
            self._lock = None

    def plan(self) -> CampaignPlan:
        """The plan of the campaign. It contains the tests of all stored runs."""
        with error_location(self.path):
            plan = CampaignPlan.from_json(unpack(self._get("plan") or b"", MAX_REPORT_BYTES))
            check_keys(self.path, self._connection, len(plan.tests))
            check_report(plan.initial_report)
        return plan

    def begin(self, utc: str, plan: CampaignPlan) -> None:
        """A session begins; the number of concretizations may have grown."""
        with error_location(self.path), self._connection:
            self._put("plan", zlib.compress(plan.to_json()))
            self._connection.execute("DELETE FROM campaign WHERE name = 'cancelled'")
            self._connection.execute("INSERT INTO sessions VALUES (?, 0)", (utc,))

    def record_duration(self, wall_s: float) -> None:
        """The session has lasted so long (s)."""
        with error_location(self.path), self._connection:
            self._connection.execute(
                "UPDATE sessions SET wall_s = ? WHERE rowid = (SELECT max(rowid) FROM sessions)", (wall_s,)
            )

    def cancel(self) -> None:
        """Ask whoever runs this campaign to stop."""
        with error_location(self.path), self._connection:
            self._put("cancelled", b"")

    @property
    def is_cancelled(self) -> bool:
        """Whether somebody asked to stop."""
        with error_location(self.path):
            return self._get("cancelled") is not None

    def add(self, key: RunKey, result: TestResult, replay: str, worker: WorkerName) -> None:
        """Keep a run; if there is one already that differs, both are kept."""
        with error_location(self.path), self._connection:
            number, sha256 = self._worker(worker), result.record_sha256 or ""
            if not self._insert(key, result.outcome, result.sim_s, sha256, number, RowSummary.of_result(result)):
                self._repeat(key, sha256, number, "")
                return
            # Level 1: a quarter of the size of a result of the table. Level 6: a fifth, in more than twice the time.
            packed = zlib.compress(encode(result).encode(), 1), zlib.compress(replay.encode(), 1) if replay else b""
            self._connection.execute("INSERT OR REPLACE INTO results VALUES (?, ?, ?, ?)", (*key, *packed))

    def add_lost(self, key: RunKey, reason: str) -> None:
        """Keep that a run cannot be done."""
        with error_location(self.path), self._connection:
            self._insert(key, LOST, 0.0, "", 0, RowSummary(note=reason))

    def _insert(self, key: RunKey, outcome: str, sim_s: float, sha256: str, worker: int, summary: RowSummary) -> bool:
        """Insert a row; False if the run has one already."""
        values = *key, outcome, sim_s, sha256, worker, encode(summary)
        inserted = self._connection.execute("INSERT OR IGNORE INTO runs VALUES (?, ?, ?, ?, ?, ?, ?)", values)
        return inserted.rowcount > 0

    def losses(self) -> list[tuple[RunKey, str]]:
        """Runs that cannot be done, and why."""
        with error_location(self.path):
            rows = self._connection.execute("SELECT * FROM runs WHERE outcome = ? ORDER BY test, k", (LOST,))
            return [(row.key, row.summary.note) for row in map(read_row, rows)]

    def forget_lost(self) -> None:
        """Runs that were lost are done again."""
        with error_location(self.path), self._connection:
            self._connection.execute("DELETE FROM runs WHERE outcome = ?", (LOST,))

    def add_repeat(self, key: RunKey, sha256: str, worker: WorkerName, parting: str) -> None:
        """Keep what a run gave on another worker."""
        with error_location(self.path), self._connection:
            self._repeat(key, sha256, self._worker(worker), parting)

    def _repeat(self, key: RunKey, sha256: str, worker: int, parting: str) -> None:
        self._connection.execute("INSERT OR REPLACE INTO again VALUES (?, ?, ?, ?, ?)", (*key, sha256, worker, parting))

    def keys(self) -> set[RunKey]:
        """The keys of all runs that have an outcome."""
        with error_location(self.path):
            return set(self._connection.execute("SELECT test, k FROM runs"))

    def counts(self) -> Counts:
        """The progress of the campaign."""
        with error_location(self.path):
            grouped = self._connection.execute(
                "SELECT outcome, count(*), total(sim_s) FROM runs GROUP BY outcome"
            ).fetchall()
            (wall_s,) = self._connection.execute("SELECT total(wall_s) FROM sessions").fetchone()
        repeats = self.repeats()
        hashes = self.hashes(repeat.key for repeat in repeats)
        differing = sum(repeat.sha256 != hashes[repeat.key] for repeat in repeats)
        sim_s = sum(group[2] for group in grouped)
        return Counts({outcome: count for outcome, count, _ in grouped}, sim_s, wall_s, len(repeats), differing)

    def rows(self) -> Iterator[Row]:
        """All runs, by test and concretization."""
        with error_location(self.path):
            for row in self._connection.execute("SELECT * FROM runs ORDER BY test, k"):
                yield read_row(row)

    def row(self, key: RunKey) -> Row:
        """One run."""
        with error_location(self.path):
            return read_row(self._connection.execute("SELECT * FROM runs WHERE test = ? AND k = ?", key).fetchone())

    def hashes(self, keys: Iterable[RunKey]) -> dict[RunKey, str]:
        """The hashes of the records of these runs."""
        with error_location(self.path):
            query = "SELECT sha256 FROM runs WHERE test = ? AND k = ?"
            stored = {key: self._connection.execute(query, key).fetchone() for key in keys}
            if lacking := [key for key, row in stored.items() if row is None]:
                raise ValueError(f"a run that is not there was repeated: {lacking[0]}")
            return {key: row[0] for key, row in stored.items()}

    def results(self, keys: Iterable[RunKey]) -> Iterator[tuple[RunKey, TestResult, str]]:
        """The whole results of runs, and the texts of their replay files."""
        query = "SELECT result, replay FROM results WHERE test = ? AND k = ?"
        for key in keys:
            with error_location(self.path):
                row = self._connection.execute(query, key).fetchone()
            if row is not None:
                with error_location(self.path):
                    packed, packed_replay = msgspec.convert(row, tuple[bytes, bytes])
                    replay = unpack(packed_replay).decode() if packed_replay else ""
                    result = msgspec.json.decode(unpack(packed), type=TestResult)
                yield key, result, replay

    def repeats(self) -> list[Repeat]:
        """Runs that were done again, in order."""
        with error_location(self.path):
            rows = self._connection.execute("SELECT test, k, sha256, worker, parting FROM again ORDER BY 1, 2, 4")
            return msgspec.convert(list(rows), list[Repeat])

    def workers(self) -> dict[int, WorkerName]:
        """Number -> worker."""
        with error_location(self.path):
            rows = self._connection.execute("SELECT id, address, host, versions FROM workers ORDER BY id").fetchall()
            return {row.id: row.name for row in msgspec.convert(rows, list[_Worker])}

    def runs_of_workers(self) -> dict[int, int]:
        """Number of a worker -> runs that it did."""
        with error_location(self.path):
            return dict(self._connection.execute("SELECT worker, count(*) FROM runs WHERE worker > 0 GROUP BY worker"))

    def _worker(self, worker: WorkerName) -> int:
        values = worker.address, worker.host, json.dumps(dict(worker.versions), sort_keys=True)
        self._connection.execute("INSERT OR IGNORE INTO workers (address, host, versions) VALUES (?, ?, ?)", values)
        query = "SELECT id FROM workers WHERE address = ? AND host = ? AND versions = ?"
        return int(self._connection.execute(query, values).fetchone()[0])

    def _schema(self) -> bytes | None:
        """The schema of an unchecked file, which may lack the table, or have an endless view of this name."""
        query = "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name = 'campaign'"
        return self._get("schema") if self._connection.execute(query).fetchone()[0] else None

    def _put(self, name: str, value: bytes) -> None:
        self._connection.execute("INSERT OR REPLACE INTO campaign VALUES (?, ?)", (name, value))

    def _get(self, name: str) -> bytes | None:
        row = self._connection.execute("SELECT value FROM campaign WHERE name = ?", (name,)).fetchone()
        return None if row is None else msgspec.convert(row[0], bytes)


class _Worker(msgspec.Struct, array_like=True):
    """A row of the workers."""

    id: int
    address: str
    host: str
    versions: str

    @property
    def name(self) -> WorkerName:
        return WorkerName(self.address, self.host, msgspec.convert(json.loads(self.versions), dict[str, str]))
