"""Recordings are read as far as they go, and what is wrong with one is a sentence with its name."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import pytest

from pytest_hricdv.recordings.recording import Recording, read_recordings
from tests.recordings.bags import BEGAN_NS, STRING, clock, text, tray, write_mcap, write_sqlite

SAID = {"/said": STRING}
BEGAN_S = BEGAN_NS / 1e9
TRAY = {"/tray": "cell_msgs/msg/Tray", "/said": STRING, "/clock": "rosgraph_msgs/msg/ClockPort"}


def reading(*paths: Path) -> list[Recording]:
    return read_recordings(paths, lambda topic: True, lambda kind: None)


def gaps(recording: Recording, topic: str) -> list[float]:
    """Times between the messages of a topic, within each part (s)."""
    parts = [[message.time_s for message in part if message.topic == topic] for part in recording.parts]
    return [after - before for times_s in parts for before, after in pairwise(times_s)]


def said(times_s: list[float]) -> list[tuple[float, str, bytes]]:
    return [(time_s, "/said", text(f"word {number}")) for number, time_s in enumerate(times_s)]


@pytest.mark.parametrize("suffix", ["mcap", "db3"])
def test_fields_are_read_with_the_definitions_of_the_bag(tmp_path: Path, suffix: str) -> None:
    write = write_mcap if suffix == "mcap" else write_sqlite
    entries = [(0.1 * n, "/tray", tray(n, -n / 2, n % 3, [n, n + 0.5], n > 5)) for n in range(12)]
    (recording,) = reading(write(tmp_path / f"run.{suffix}", entries, TRAY))
    first, *_, last = (message.fields for part in recording.parts for message in part)
    assert dict(first) == {"pose.x": 0.0, "pose.y": 0.0, "cups": 0.0, "loads": (0.0, 0.5), "is_wet": False}
    assert dict(last) == {"pose.x": 11.0, "pose.y": -5.5, "cups": 2.0, "loads": (11.0, 11.5), "is_wet": True}


def test_times_are_those_of_the_clock_of_the_simulation(tmp_path: Path) -> None:
    ticks = [(float(n), "/clock", clock(n / 4)) for n in range(20)]
    entries = sorted([*ticks, (2.0, "/said", text("a")), (4.0, "/said", text("b"))])
    (recording,) = reading(write_mcap(tmp_path / "run.mcap", entries, TRAY))
    assert recording.notes == ("run.mcap: times are those of /clock",)
    assert gaps(recording, "/said") == pytest.approx([0.5])


def truncated(folder: Path) -> Path:
    file = write_mcap(folder / "run.mcap", said([0.1 * n for n in range(2000)]), SAID)
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    return file


def with_bytes(folder: Path, name: str, data: bytes) -> Path:
    (folder / name).write_bytes(data)
    return folder / name


BAD: dict[str, tuple[Callable[[Path], Path], str, int]] = {
    "empty MCAP": (lambda f: with_bytes(f, "run.mcap", b""), "run.mcap: not an MCAP file that can be read", 0),
    "empty SQLite": (
        lambda f: with_bytes(f, "run.db3", b""),
        "run.db3: no recording of ROS 2: without a table",
        0,
    ),
    "log that is not merged": (
        lambda f: (with_bytes(f, "run.db3-wal", b"frames"), with_bytes(f, "run.db3", b""))[1],
        "run.db3-wal has messages that are not in the database yet",
        0,
    ),
    "cut off": (truncated, "run.mcap: not an MCAP file that can be read, or cut off", 900),
    "table": (lambda f: with_bytes(f, "run.csv", b"time,topic\n"), "run.csv: the file is neither *.mcap nor *.db3", 0),
    "no message": (lambda f: write_mcap(f / "run.mcap", []), "run.mcap: has no messages: nothing was observed", 0),
    "unknown type": (
        lambda f: write_mcap(f / "run.mcap", said([0.0, 1.0]), {"/said": "odd_msgs/msg/Odd"}),
        "type odd_msgs/msg/Odd is defined neither in the file nor here: install its package; of 2 messages",
        2,
    ),
    "other format": (
        lambda f: write_mcap(f / "run.mcap", said([0.0]), SAID, encoding="protobuf"),
        "run.mcap: /said: its messages are protobuf; expected cdr or json; of 1 message only",
        1,
    ),
    "big endian": (
        lambda f: write_mcap(f / "run.mcap", [(0.0, "/said", b"\x00\x00\x00\x00\x00\x00\x00\x01a\x00")], SAID),
        "run.mcap: /said: its bytes are not a std_msgs/msg/String",
        1,
    ),
    "too few bytes": (
        lambda f: write_mcap(f / "run.mcap", [(0.0, "/said", text("a long text")[:-5])], SAID),
        "run.mcap: /said: its bytes are not a std_msgs/msg/String",
        1,
    ),
    "clock set back": (
        lambda f: write_mcap(f / "run.mcap", said([0.0, 1.0, -50.0, -49.0]), SAID),
        "run.mcap: message 3 (/said): the clock goes back by 51 s: times across it are not counted",
        4,
    ),
    "clock set forward": (
        lambda f: write_mcap(f / "run.mcap", said([0.0, 1.0, 5000.0, 5001.0]), SAID),
        "run.mcap: message 3 (/said): the clock jumps by 5e+03 s",
        4,
    ),
    "times that rolled over": (  # ros2/rosbag2 issue 2389
        lambda f: write_mcap(f / "run.mcap", said([1.0, 2.0, 9e9, 3.0, 4.0]), SAID),
        "run.mcap: message 4 (/said): the clock goes back by 9e+09 s",
        5,
    ),
    "simulation begun again": (
        lambda f: write_mcap(
            f / "run.mcap",
            [entry for n in range(40) for entry in ((n, "/clock", clock(n % 20)), (n + 0.5, "/said", text("a")))],
            TRAY,
        ),
        "the clock goes back by",
        40,
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_wrong_is_a_sentence_and_the_rest_is_used(tmp_path: Path, case: str) -> None:
    make, problem, least = BAD[case]
    path = make(tmp_path)
    (recording,) = reading(path)
    assert problem in " ".join(recording.problems)
    assert sum(map(len, recording.parts)) >= least
    topics = {message.topic for part in recording.parts for message in part}
    assert all(0.0 <= gap_s < 15.0 for topic in topics for gap_s in gaps(recording, topic))
