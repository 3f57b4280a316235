"""Bags as a stimulus: what was recorded is published in simulated time, or it is said why not."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from mcap.writer import Writer

from pytest_hricdv.extra.ros2.clocks import EPOCH_NS
from pytest_hricdv.extra.ros2.kit.bag import BagError, read_bag
from pytest_hricdv.extra.ros2.messages import import_type, serialize
from pytest_hricdv.ros2 import BagPlayer
from tests.extra.ros2.test_kit import World

_RECORDED_NS = 1_700_000_000 * 10**9
"""When the bag began; a time of the system, as recorders use it."""

_METADATA = """rosbag2_bagfile_information:
  version: 5
  storage_identifier: {storage}
  relative_file_paths: [{file}]
  duration: {{nanoseconds: 3000000000}}
  starting_time: {{nanoseconds_since_epoch: 1700000000000000000}}
  message_count: {count}
  topics_with_message_count: {topics}
  compression_format: "{compression}"
  compression_mode: "{mode}"
"""

_TIME = "{sec: 2147483647, nsec: 4294967295}"
_QOS = f"""- history: 3
  depth: 0
  reliability: 1
  durability: DURABILITY
  deadline: {_TIME}
  lifespan: {_TIME}
  liveliness: 1
  liveliness_lease_duration: {_TIME}
  avoid_ros_namespace_conventions: false
"""
"""As the recorder of foxy to iron writes it."""

_TYPES = {
    "/said": "std_msgs/msg/String",
    "/scan": "sensor_msgs/msg/LaserScan",
    "/map": "std_msgs/msg/String",
    "/gone/_action/feedback": "no_msgs/msg/Nothing",
    "/odd": "no_msgs/msg/Nothing",
}


@pytest.fixture
def world(ros_messages: None) -> World:
    return World()


def _text(data: str) -> bytes:
    kind = import_type("std_msgs/msg/String", "msg")
    return serialize(kind(data=data), kind)


def _scan(at_s: float) -> bytes:
    kind = import_type("sensor_msgs/msg/LaserScan", "msg")
    scan = kind()
    scan.header.stamp.sec, scan.header.stamp.nanosec = divmod(_RECORDED_NS + round(at_s * 1e9), 10**9)
    return serialize(scan, kind)


Entry = tuple[float, str, bytes]


def _qos(topic: str) -> str:
    return _QOS.replace("DURABILITY", "1" if topic == "/map" else "2")


def _write_mcap(file: Path, entries: Sequence[Entry], encoding: str = "cdr") -> None:
    with file.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2")
        channels = {}
        for topic in dict.fromkeys(topic for _, topic, _ in entries):
            schema = writer.register_schema(_TYPES[topic], "ros2msg", b"")
            channels[topic] = writer.register_channel(topic, encoding, schema, {"offered_qos_profiles": _qos(topic)})
        for at_s, topic, data in entries:
            time_ns = _RECORDED_NS + round(at_s * 1e9)
            writer.add_message(channels[topic], time_ns, data, time_ns)
        writer.finish()  # type: ignore[no-untyped-call]


def _write_sqlite(file: Path, entries: Sequence[Entry], encoding: str = "cdr") -> None:
    connection = sqlite3.connect(file)
    connection.execute(
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format, offered_qos_profiles)"
    )
    connection.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data)")
    topics = list(dict.fromkeys(topic for _, topic, _ in entries))
    for topic in topics:
        row = (topics.index(topic), topic, _TYPES[topic], encoding, _qos(topic))
        connection.execute("INSERT INTO topics VALUES(?, ?, ?, ?, ?)", row)
    for at_s, topic, data in entries:
        message = (topics.index(topic), _RECORDED_NS + round(at_s * 1e9), data)
        connection.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", message)
    connection.commit()
    connection.close()


def _write(folder: Path, suffix: str, entries: Sequence[Entry], *, encoding: str = "cdr") -> Path:
    folder.mkdir()
    (_write_mcap if suffix == "mcap" else _write_sqlite)(folder / f"walk_0.{suffix}", entries, encoding)
    _write_metadata(folder, f"walk_0.{suffix}", entries, encoding)
    return folder


def _write_metadata(
    folder: Path, file: str, entries: Sequence[Entry], encoding: str = "cdr", compression: str = ""
) -> None:
    topics = [
        {
            "topic_metadata": {
                "name": topic,
                "type": _TYPES[topic],
                "serialization_format": encoding,
                "offered_qos_profiles": _qos(topic),
            },
            "message_count": sum(each == topic for _, each, _ in entries),
        }
        for topic in dict.fromkeys(topic for _, topic, _ in entries)
    ]
    metadata = _METADATA.format(
        storage="mcap" if "mcap" in file else "sqlite3",
        file=file,
        count=len(entries),
        topics=json.dumps(topics),
        compression="zstd" if compression else "",
        mode=compression,
    )
    (folder / "metadata.yaml").write_text(metadata)


def _walk() -> list[Entry]:
    return [
        (0.0, "/map", _text("map")),
        (1.0, "/said", _text("a")),
        (2.5, "/said", _text("b")),
        (3.0, "/scan", _scan(2.9)),
    ]


def _heard(world: World, limit_s: float = 20.0) -> list[tuple[float, str]]:
    world.play(lambda: world.kernel.sleep(limit_s))
    return [(message.time_s, str(message.fields.get("data", message.topic))) for message in world.recorder.messages]


@pytest.mark.parametrize("suffix", ["mcap", "db3"])
@pytest.mark.parametrize("has_metadata", [True, False])
def test_a_bag_is_published_in_simulated_time(world: World, tmp_path: Path, suffix: str, has_metadata: bool) -> None:
    bag = _write(tmp_path / "walk", suffix, _walk())
    if not has_metadata:
        (bag / "metadata.yaml").unlink()
    player = BagPlayer(world.ros, bag)
    assert _heard(world) == [(0.0, "map"), (1.0, "a"), (2.5, "b"), (3.0, "scan")]
    assert player.is_over


@pytest.mark.parametrize(
    ("shift", "expected_ns"), [(True, EPOCH_NS + 1_950_000_000), (False, _RECORDED_NS + 2_900_000_000)]
)
def test_stamps_are_as_old_as_when_they_were_recorded(
    world: World, tmp_path: Path, shift: bool, expected_ns: int
) -> None:
    scans = world.ros.node("listener").subscribe("/scan", "sensor_msgs/msg/LaserScan")
    stamps = []

    def listen() -> None:
        message = scans.wait(10.0)
        stamps.append(message.header.stamp.sec * 10**9 + message.header.stamp.nanosec)

    BagPlayer(world.ros, _write(tmp_path / "walk", "db3", _walk()), rate=2.0, delay_s=0.5, shift_stamps=shift)
    world.play(listen)
    assert stamps == [expected_ns]


def test_a_latched_topic_reaches_later_subscriptions(world: World, tmp_path: Path) -> None:
    BagPlayer(world.ros, _write(tmp_path / "walk", "db3", _walk()))
    assert read_bag(tmp_path / "walk").topics["/map"].latched
    assert not read_bag(tmp_path / "walk").topics["/said"].latched


def _cut(file: Path) -> None:
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])


_NOTHING = [(0.0, "/odd", b""), (0.0, "/gone/_action/feedback", b"")]


@pytest.mark.parametrize(
    ("make", "options", "message"),
    [
        (lambda to: to / "none", {}, r"bag .*none: there is no such file or folder; paths begin where pytest"),
        (lambda to: (to / "empty").mkdir() or to / "empty", {}, r"neither metadata\.yaml nor a file \*\.mcap"),
        (lambda to: _write(to / "b", "mcap", _walk()), {"topics": ["/sad"]}, r"no topic '/sad'; nearest: /said, "),
        (lambda to: _write(to / "b", "mcap", _walk()), {"rate": 0.0}, r"rate=0\.0; expected a number above 0"),
        (lambda to: _write(to / "b", "mcap", _walk()), {"start_s": 9}, r"start_s=9, but it is 3\.000 s long"),
        (lambda to: _write(to / "b", "mcap", _walk()[:1]), {"loop": True}, r"all messages are of one instant"),
        (lambda to: _write(to / "b", "db3", []), {}, r"there is no message in it"),
        (lambda to: _write(to / "b", "db3", _NOTHING), {}, r"types are not installed: /odd \(no_msgs/msg/Nothing\); "),
        (lambda to: _write(to / "b", "db3", _walk(), encoding="json"), {}, r"format {'json'} is not supported"),
    ],
)  # fmt: skip
@pytest.mark.usefixtures("ros_messages")
def test_what_cannot_be_played_is_said(
    world: World, tmp_path: Path, make: Any, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(BagError, match=message) as raised:
        BagPlayer(world.ros, make(tmp_path), **options)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("suffix", ["mcap", "db3"])
@pytest.mark.usefixtures("ros_messages")
def test_a_file_that_is_cut_off_is_said_to_be(tmp_path: Path, suffix: str) -> None:
    bag = _write(tmp_path / "walk", suffix, [(i * 0.1, "/said", _text("x" * 2000)) for i in range(30)])
    _cut(bag / f"walk_0.{suffix}")
    with pytest.raises(BagError, match="walk: cannot be read, perhaps cut off"):
        read_bag(bag)
