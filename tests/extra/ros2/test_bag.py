"""The bag of a run, read back by the decoder of MCAP's authors: bytes and definitions have to fit each other."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from pytest_hricdv.extra.ros2 import bag_writer
from pytest_hricdv.extra.ros2.clocks import EPOCH_NS
from pytest_hricdv.extra.ros2.messages import RosMessage, import_type
from pytest_hricdv.runtime import Recorder

_FILES = {
    "cell_io/msg/Empty.msg": "",
    "cell_io/msg/Point.msg": "float64 x\nuint8 kind\n",
    "cell_io/msg/Scan.msg": "bool near\nstring frame\nint16[3] counts\nfloat32[] ranges\nPoint origin\n"
    "Point[<=5] points\nstring[] names\nint64 stamp\n",
}


@pytest.fixture
def cell_io(interfaces: Callable[[Mapping[str, str]], None]) -> Any:
    """The classes of some messages."""
    interfaces(_FILES)
    names = ("Empty", "Point", "Scan")
    return SimpleNamespace(**{name: import_type(f"cell_io/msg/{name}", "msg") for name in names})


def _scan(cell_io: Any) -> Any:
    return cell_io.Scan(
        near=True,
        frame="map",
        counts=[1, -2, 3],
        ranges=[0.5, math.inf],
        origin=cell_io.Point(x=1.5, kind=7),
        points=[cell_io.Point(x=2.5), cell_io.Point(kind=255)],
        names=["a", "ä"],
        stamp=-(2**62),
    )


def test_a_definition_has_those_of_what_it_contains(cell_io: Any) -> None:
    assert bag_writer.definition_of(cell_io.Scan) == "\n".join(
        [
            "bool near",
            "string frame",
            "int16[3] counts",
            "float32[] ranges",
            "cell_io/Point origin",
            "cell_io/Point[<=5] points",
            "string[] names",
            "int64 stamp",
            "=" * 80,
            "MSG: cell_io/Point",
            "float64 x",
            "uint8 kind",
        ]
    )


def _record(cell_io: Any) -> Any:
    recorder = Recorder()
    for number, source in enumerate(
        [
            RosMessage("/cell/scan", "", _scan(cell_io)),
            RosMessage("/grasp", "request", cell_io.Empty()),
            None,
            RosMessage("/done", "", cell_io.Empty()),
            RosMessage("/cell/scan", "", cell_io.Scan()),
        ]
    ):
        recorder.message(number / 4, "lidar", "topic", {}, source)
    return recorder.finish()


def test_the_messages_of_topics_are_read_back(tmp_path: Path, cell_io: Any) -> None:
    file = tmp_path / "run.ros2.mcap"
    assert bag_writer.write_bag(file, _record(cell_io))
    with file.open("rb") as opened:
        reader = make_reader(opened, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        found = [
            (channel.topic, message.log_time, each) for _, channel, message, each in reader.iter_decoded_messages()
        ]
    assert [(topic, time_ns) for topic, time_ns, _ in found] == [
        ("/cell/scan", EPOCH_NS),
        ("/done", EPOCH_NS + 750_000_000),
        ("/cell/scan", EPOCH_NS + 1_000_000_000),
    ]
    assert _plain(found[0][2]) == _plain(_scan(cell_io))
    assert _plain(found[2][2]) == _plain(cell_io.Scan())


def _plain(message: Any) -> dict[str, Any]:
    """The fields of a message of either kind, as values of Python."""
    point = ("x", "kind")
    return {
        **{name: getattr(message, name) for name in ("near", "frame", "stamp")},
        **{name: list(getattr(message, name)) for name in ("counts", "ranges", "names")},
        "origin": [getattr(message.origin, name) for name in point],
        "points": [[getattr(each, name) for name in point] for each in message.points],
    }


@pytest.mark.skipif(find_spec("sensor_msgs") is None, reason="needs sensor_msgs, of a ROS 2 distribution")
def test_generated_messages_are_read_back(tmp_path: Path) -> None:
    from geometry_msgs.msg import Pose, PoseArray  # type: ignore[import-not-found, unused-ignore]
    from sensor_msgs.msg import (  # type: ignore[import-not-found, unused-ignore]
        CompressedImage,
        LaserScan,
        PointCloud2,
        PointField,
    )

    scan = LaserScan(ranges=[0.5, 1.5, math.inf], angle_increment=0.25)
    scan.header.frame_id, scan.header.stamp.sec = "lidar", 7
    poses = PoseArray(poses=[Pose(), Pose()])
    poses.poses[1].orientation.w = 0.5
    cloud = PointCloud2(fields=[PointField(name="x", offset=4, datatype=PointField.FLOAT32)], data=b"abcd")
    sent = {"/scan": scan, "/poses": poses, "/cloud": cloud, "/image": CompressedImage(format="png", data=b"\x89P")}
    recorder = Recorder()
    for topic, message in sent.items():
        recorder.message(0.0, "robot", topic, {}, RosMessage(topic, "", message))
    assert bag_writer.write_bag(tmp_path / "bag", recorder.finish())
    with (tmp_path / "bag").open("rb") as opened:
        reader = make_reader(opened, decoder_factories=[DecoderFactory()])
        found = {channel.topic: message for _, channel, _, message in reader.iter_decoded_messages()}
    scan, poses, cloud, image = (found[topic] for topic in sent)
    assert (scan.header.frame_id, scan.header.stamp.sec, scan.angle_increment) == ("lidar", 7, 0.25)
    assert list(scan.ranges) == [0.5, 1.5, math.inf]
    assert [pose.orientation.w for pose in poses.poses] == [1.0, 0.5]
    assert [(field.name, field.offset, field.datatype) for field in cloud.fields] == [("x", 4, 7)]
    assert (bytes(cloud.data), image.format, bytes(image.data)) == (b"abcd", "png", b"\x89P")


def test_a_run_without_topics_has_no_bag(tmp_path: Path) -> None:
    assert not bag_writer.write_bag(tmp_path / "run", SimpleNamespace(messages=()))  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == []
