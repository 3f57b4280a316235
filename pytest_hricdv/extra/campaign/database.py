"""The SQLite database of a campaign: its tables, how it is opened, and the errors of a damaged file.

`Store` opens it with `connect` and `check_tables`, and reads each run as a `Row`, with a `RowSummary` from which sums
are computed. The file may come from elsewhere, as an artefact does, and SQL in it would run here: a view in place of a
table may be endless, a trigger changes what is stored. So `check_tables` accepts only the tables that the plugin makes;
contents of cells are checked when they are read.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import msgspec
from msgspec import Meta

from pytest_hricdv._base.contained import file_inside
from pytest_hricdv._base.record import Count, NotNegative, Number
from pytest_hricdv.execution.outcome import TestOutcome
from pytest_hricdv.extra.campaign.plan import CampaignError, RunKey
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.results.model import TestResult

LOST: Final = "lost"
"""The outcome of a run that ended its process, or its worker, at each attempt."""

Bits = Annotated[str, Meta(pattern=r"^0x[0-9a-f]+\Z")]
"""A bit set, in hexadecimal."""

Judgement = tuple[Literal["Passed", "Failed", "NC"], Count, Number | None]
"""Verdict of a requirement, how often it was triggered, and its margin."""


class RowSummary(msgspec.Struct, frozen=True):
    """A run's contribution to sums; for a lost run only the reason.

    Args:
        note: the first line of why it failed or was lost.
        judgements: one for each requirement, sorted by requirement.
        bins: cross product -> the bins that were hit.
        endings: how each interaction ended.
        statements: covered, as a bit set; likewise branches.
    """

    note: str = ""
    judgements: tuple[Judgement, ...] = ()
    bins: Mapping[str, list[list[str]]] = {}
    endings: tuple[str, ...] = ()
    statements: Bits = "0x0"
    branches: Bits = "0x0"

    @classmethod
    def of_result(cls, result: TestResult) -> RowSummary:
        """Summarize the result of a run."""
        judged = [result.requirements[name] for name in sorted(result.requirements)]
        statements, branches = result.code.bits if result.code else ("0x0", "0x0")
        return cls(
            note=result.failure.strip().partition("\n")[0] if result.fails else "",
            judgements=tuple((judgement.verdict, judgement.triggers, judgement.margin) for judgement in judged),
            bins={name: [list(hit) for hit in sorted(set(hits))] for name, hits in (result.cross or {}).items()},
            endings=tuple(result.outcomes),
            statements=statements,
            branches=branches or "0x0",
        )


class Row(msgspec.Struct, frozen=True, array_like=True):
    """A row of the store: columns that queries use, and the summary."""

    test: Count
    k: Count
    outcome: TestOutcome | Literal["lost"]
    sim_s: NotNegative
    sha256: str
    worker: Count
    summary: RowSummary

    @property
    def key(self) -> RunKey:
        """The run that it is of."""
        return self.test, self.k


def read_row(cells: tuple[Any, ...]) -> Row:
    """Check the cells of a row: columns of SQLite take values of any type.

    Raises:
        msgspec.MsgspecError: they are no such row.
    """
    *columns, summary = cells
    return msgspec.convert((*columns, msgspec.json.decode(msgspec.convert(summary, str))), Row)


TABLES = """
CREATE TABLE campaign (name TEXT PRIMARY KEY, value BLOB) WITHOUT ROWID;
CREATE TABLE workers (id INTEGER PRIMARY KEY, address TEXT, host TEXT, versions TEXT, UNIQUE (address, host, versions));
CREATE TABLE runs (
    test INTEGER, k INTEGER, outcome TEXT, sim_s REAL, sha256 TEXT, worker INTEGER, summary TEXT,
    PRIMARY KEY (test, k)) WITHOUT ROWID;
CREATE INDEX outcomes ON runs (outcome, sim_s);
CREATE TABLE results (test INTEGER, k INTEGER, result BLOB, replay BLOB, PRIMARY KEY (test, k));
CREATE TABLE again (test INTEGER, k INTEGER, sha256 TEXT, worker INTEGER, parting TEXT, PRIMARY KEY (test, k, worker));
CREATE TABLE sessions (began_utc TEXT, wall_s REAL);
"""

_BESIDE = ("-wal", "-shm", "-journal")
"""Suffixes of the files that SQLite writes next to a database."""

MAX_K = 10_000_000
"""Most concretizations of a test, and the largest number that the command line takes: what is more is a slip."""

_STRANGE_KEYS = "SELECT count(*) FROM {} WHERE typeof(test) != 'integer' OR typeof(k) != 'integer' OR test < 0 \
OR test >= ? OR k < 0 OR k >= ?"


def connect(path: Path) -> sqlite3.Connection:
    """A connection to the file, which is made where it is missing.

    Raises:
        OSError: SQLite would write through a symbolic link next to it.
        sqlite3.Error: it cannot be opened.
    """
    for ending in _BESIDE:
        file_inside(path.parent, path.name + ending)
    connection = sqlite3.connect(path, timeout=30)  # s: `status` and `report` hold their locks for moments only
    connection.execute("PRAGMA trusted_schema = OFF")  # functions that SQL in the file may call: harmless ones only
    connection.execute("PRAGMA journal_mode = WAL")
    # The write-ahead log keeps the file intact; a power failure may cost the last rows, which are run again.
    connection.execute("PRAGMA synchronous = NORMAL")
    return connection


def check_tables(path: Path, connection: sqlite3.Connection) -> None:
    """Check that the file has the tables of a campaign.

    Raises:
        CampaignError: one is missing or another one, or there is a view or a trigger.
    """
    with sqlite3.connect(":memory:") as made:
        made.executescript(TABLES)
        expected = _tables(made)
    made.close()
    tables = _tables(connection)
    for name, statement in expected.items():
        if tables.get(name) != statement:
            raise damage_error(path, f"its table {name} is {'another one' if name in tables else 'missing'}")
    if strange := sorted(kind for kind, _ in tables.values() if kind in ("view", "trigger")):
        raise damage_error(path, f"there is a {strange[0]} in it, and campaigns have none")


def _tables(connection: sqlite3.Connection) -> dict[str, tuple[str, str]]:
    """Name -> kind and SQL, without what SQLite makes itself."""
    rows = connection.execute("SELECT type, name, sql FROM sqlite_master").fetchall()
    return {name: (kind, " ".join(str(sql).split())) for kind, name, sql in rows if not name.startswith("sqlite_")}


def check_keys(path: Path, connection: sqlite3.Connection, tests: int) -> None:
    """Check that all rows are of tests of the plan. Raises CampaignError."""
    for table in ("runs", "results", "again"):
        (count,) = connection.execute(_STRANGE_KEYS.format(table), (tests, MAX_K)).fetchone()
        if count:
            raise damage_error(path, f"{count:,} rows of {table} are of no test of its plan")


@contextmanager
def error_location(path: Path) -> Iterator[None]:
    """Errors of the file, with its name and what to do."""
    try:
        yield
    except sqlite3.OperationalError as error:
        if "no such table" in str(error):
            raise damage_error(path, error) from None
        raise CampaignError(
            f"{path}: cannot be read or written: {error}; what was stored before is kept; the same command resumes"
        ) from None
    except OSError as error:
        raise CampaignError(f"{error.filename or path}: {error.strerror or error}") from None
    except (sqlite3.DatabaseError, msgspec.MsgspecError, ValueError, OverflowError, GenerateError) as error:
        raise damage_error(path, error) from None
    except RecursionError:
        raise damage_error(path, "nested too deeply") from None


def damage_error(path: Path, why: object) -> CampaignError:
    """The error of a file that is not a campaign's, or no longer."""
    return CampaignError(
        f"{path}: damaged, or not a campaign ({why}): 'sqlite3 {path} .recover' may save its rows; otherwise give "
        "another --state"
    )
