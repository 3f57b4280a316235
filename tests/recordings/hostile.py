"""Damaged and hostile recordings, and what is said of each: `python -m tests.recordings.hostile FOLDER` reads them all.

It prints a line of JSON for each: its name, what was said, how many messages were read, and how long that took (s); at
last the greatest memory of the process (bytes), and the files that are new.
"""

from __future__ import annotations

import json
import os
import resource
import sqlite3
import struct
import sys
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import lz4.frame  # type: ignore[import-untyped]
import zstandard

from pytest_hricdv.recordings import recording
from tests.recordings.bags import STRING, text, write_mcap

MEMORY_BYTES = 1_500_000_000
"""Address space of the process that reads them: what is read within limits stays far below."""

_MAGIC = b"\x89MCAP0\r\n"
_EMPTY = struct.pack("<I", 0)
_GOOD = struct.pack("<HIQQ", 1, 0, 10**18, 10**18) + b'{"a": 1}'
_Make = Callable[[Path], Path]


def _record(opcode: int, data: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(data)) + data


def _text(value: str) -> bytes:
    return struct.pack("<I", len(value)) + value.encode()


_CHANNEL = _record(4, struct.pack("<HH", 1, 0) + _text("/said") + _text("json") + _EMPTY)


def _mcap(folder: Path, *records: bytes) -> Path:
    file = folder / "run.mcap"
    file.write_bytes(_MAGIC + _record(1, _EMPTY * 2) + _CHANNEL + b"".join(records))
    return file


def _chunk(packed: bytes, compression: str, size: int) -> bytes:
    head = struct.pack("<QQQI", 0, 0, size, 0) + _text(compression) + struct.pack("<Q", len(packed))
    return _record(6, head + packed)


def _zeros(size: int) -> bytes:
    """Zeros of zstd, packed without ever having all of them."""
    packing = zstandard.ZstdCompressor().compressobj()
    return b"".join(packing.compress(bytes(1_000_000)) for _ in range(size // 1_000_000)) + packing.flush()


def _padding(size: int) -> bytes:
    """One record of no known kind, of zeros."""
    return bytes(zstandard.compress(_record(200, bytes(size))))


def _lz4_zeros(size: int) -> bytes:
    with lz4.frame.LZ4FrameCompressor() as packing:
        made = packing.begin() + b"".join(packing.compress(bytes(1_000_000)) for _ in range(size // 1_000_000))
        return bytes(made + packing.flush())


def _json(folder: Path, content: str) -> Path:
    return write_mcap(folder / "run.mcap", [(0.0, "/said", content.encode()), (1.0, "/said", {"a": 1})])


def _cdr(folder: Path, definition: str, data: bytes) -> Path:
    kind = "odd_msgs/msg/Odd"
    schema = _record(3, struct.pack("<H", 7) + _text(kind) + _text("ros2msg") + _text(definition))
    channel = _record(4, struct.pack("<HH", 2, 7) + _text("/odd") + _text("cdr") + _EMPTY)
    message = _record(5, struct.pack("<HIQQ", 2, 0, 10**18, 10**18) + b"\x00\x01\x00\x00" + data)
    return _mcap(folder, schema, channel, message)


_TOPICS = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT)"
_MESSAGES = "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)"
_ENDLESS = "WITH RECURSIVE r(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM r)"


def _database(folder: Path, *commands: str, name: str = "run.db3", rows: int = 3) -> Path:
    with closing(sqlite3.connect(folder / name, isolation_level=None)) as database:
        for command in commands or (_TOPICS, _MESSAGES):
            database.execute(command)
        if not commands:
            database.execute("INSERT INTO topics VALUES(1, '/said', ?, 'cdr')", (STRING,))
            data = [(1, 10**18 + n, text(f"{n:0900}")) for n in range(rows)]
            database.executemany("INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", data)
    return folder / name


def _one_leaf(folder: Path) -> Path:
    """A table of which all inner pages, ten levels of them, have one and the same child many times."""
    file = _database(folder, rows=5_000)
    pages = bytearray(file.read_bytes())
    size = int.from_bytes(pages[16:18], "big")
    with closing(sqlite3.connect(file)) as database:
        (root,) = database.execute("SELECT rootpage FROM sqlite_master WHERE name = 'messages'").fetchone()
    inner = [root, *(n + 1 for n in range(1, len(pages) // size) if pages[n * size] == 5 and n + 1 != root)]
    leaf = next(n + 1 for n in range(1, len(pages) // size) if pages[n * size] == 13)
    for number, child in zip(inner, [*inner[1:], leaf], strict=True):
        start = (number - 1) * size
        cells = int.from_bytes(pages[start + 3 : start + 5], "big")
        pages[start + 8 : start + 12] = child.to_bytes(4, "big")
        for cell in range(cells):
            place = start + int.from_bytes(pages[start + 12 + 2 * cell : start + 14 + 2 * cell], "big")
            pages[place : place + 4] = child.to_bytes(4, "big")
    file.write_bytes(pages)
    return file


def _aliases(folder: Path) -> Path:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]" for n in range(1, 30)]
    (folder / "metadata.yaml").write_text("\n".join(lines), encoding="utf-8")
    _database(folder)
    return folder


def _pipe(folder: Path) -> Path:
    os.mkfifo(folder / "run.mcap")
    return folder / "run.mcap"


def _linked(folder: Path) -> Path:
    (folder / "run.mcap").symlink_to("run.mcap")
    return folder / "run.mcap"


def _folder(folder: Path) -> Path:
    (folder / "run.mcap").mkdir()
    return folder / "run.mcap"


_TOPIC = "INSERT INTO topics VALUES(1, 'a', 'b', 'cdr')"
_ENDLESS_MESSAGES = f"CREATE VIEW messages AS {_ENDLESS} SELECT 1 AS topic_id, n AS timestamp, x'00' AS data FROM r"
_ENDLESS_TOPICS = f"CREATE VIEW topics AS {_ENDLESS} SELECT n AS id, 'x' AS name, 'y' AS type, 'cdr' AS encoding FROM r"
_VIRTUAL = "CREATE VIRTUAL TABLE messages USING fts5(topic_id, timestamp, data)"
_COLUMN = "CREATE TABLE messages(topic_id, timestamp, data BLOB AS (zeroblob(900000000)))"
_HEADS = _record(5, _GOOD[:22])
"""A message without data."""

HOSTILE: dict[str, tuple[_Make, str]] = {
    "name with %2F": (lambda f: _database(f, name="..%2F..%2Frun.db3"), ""),
    "name with # and ?": (lambda f: _database(f, name="run#1?mode=rwc.db3"), ""),
    "endless view": (lambda f: _database(f, _TOPICS, _ENDLESS_MESSAGES), "without a table messages"),
    "endless topics": (lambda f: _database(f, _MESSAGES, _ENDLESS_TOPICS), "without a table topics"),
    "virtual table": (lambda f: _database(f, _TOPICS, _VIRTUAL), "without a table messages"),
    "column that is made": (
        lambda f: _database(f, _TOPICS, _COLUMN, _TOPIC, "INSERT INTO messages VALUES(1, 1)"),
        "too big",
    ),
    "row without data": (
        lambda f: _database(f, _TOPICS, _MESSAGES, _TOPIC, "INSERT INTO messages VALUES(1, 1, 'soon', NULL)"),
        "no topic, time or data",
    ),
    "pages in a ring": (_one_leaf, "run.db3: "),
    "aliases of YAML": (_aliases, ""),
    "zstd of 300 MB": (lambda f: _mcap(f, _chunk(_zeros(300_000_000), "zstd", 100)), "a chunk unpacks to more"),
    "lz4 of 300 MB": (lambda f: _mcap(f, _chunk(_lz4_zeros(300_000_000), "lz4", 100)), "a chunk unpacks to more"),
    "chunks of 90 MB": (lambda f: _mcap(f, *[_chunk(_padding(90_000_000), "zstd", 100)] * 40), "200 times its size"),
    "messages in a chunk": (
        lambda f: _mcap(f, _chunk(zstandard.compress(_HEADS * 250_000), "zstd", 1)),
        "more than 200,000 messages",
    ),
    "unknown compression": (lambda f: _mcap(f, _chunk(b"x", "rar", 1)), "compressed with 'rar'"),
    "record of 2^60 bytes": (lambda f: _mcap(f, struct.pack("<BQ", 5, 2**60)), "run.mcap: not an MCAP file"),
    "chunk cut in a record": (lambda f: _mcap(f, _chunk(struct.pack("<BQ", 5, 2**60), "", 9)), "ends within one"),
    "unknown channel": (lambda f: _mcap(f, _record(5, b"\x09" + _GOOD[1:])), "run.mcap: not an MCAP file"),
    "integer of 400 digits": (lambda f: _json(f, f'{{"a": 1{"0" * 400}}}'), "/said: a number of more than 308 digits"),
    "integer of 9,000 digits": (lambda f: _json(f, f'{{"a": [1{"0" * 9000}]}}'), "/said: its bytes are not JSON"),
    "deep JSON": (lambda f: _json(f, '{"a": ' * 800 + "1" + "}" * 800), "/said: nested too deeply"),
    "very deep JSON": (lambda f: _json(f, "[" * 100_000), "/said: its bytes are not JSON"),
    "texts among numbers": (lambda f: _json(f, f'{{"a": [1, "x"{", 1" * 2000}]}}'), ""),
    "list of 2^32 items": (lambda f: _cdr(f, "float64[] a\n", b"\xff" * 8), "its bytes are not a odd_msgs/msg/Odd"),
    "array of 10^12 items": (lambda f: _cdr(f, "uint8[1000000000000] a\n", b"\x01" * 8), "/odd: "),
    "type within itself": (lambda f: _cdr(f, "odd_msgs/Odd a\n", b"\x01" * 8), "/odd: "),
    "long definition": (lambda f: _cdr(f, "uint8 a\n" * 200_000, b"\x01"), "more than 1,000,000 characters"),
    "definition of brackets": (lambda f: _cdr(f, "uint8 a = " + "(" * 50_000, b"\x01"), ""),
    "pipe": (_pipe, "a folder, a pipe or a device"),
    "link to itself": (_linked, "there is no such file"),
    "folder by the name of a file": (_folder, "no file *.mcap"),
}
"""Case -> how its file is made, and what is said of it; empty where it is read as it is."""


def main(folder: Path) -> None:
    """Make all of them, in memory without a limit, then read each within one."""
    made = []
    for number, (name, (make, _)) in enumerate(HOSTILE.items()):
        (folder / str(number)).mkdir()
        made.append((name, make(folder / str(number))))
    before = set(folder.rglob("*"))
    pid = os.fork()  # the peak of the process that made them is not that of reading them
    if pid:
        os.waitpid(pid, 0)
        print(json.dumps({"new": sorted(str(path) for path in {*folder.rglob("*")} - before)}))
        return
    vars(recording)["MAX_VALUES"] = 200_000
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    for name, path in made:
        began_s = time.monotonic()
        (read,) = recording.read_recordings([path], lambda topic: True, lambda kind: None)
        count = sum(map(len, read.parts))
        line = {"name": name, "said": list(read.problems), "count": count, "s": time.monotonic() - began_s}
        print(json.dumps(line), flush=True)
    print(json.dumps({"peak": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024}), flush=True)
    os._exit(0)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
