"""Speed and memory of checking logs: events a second of one core, and the greatest memory, by the size of the log.

    python -m benchmarks.logs [--events N] [--megabytes N ...]

A log has an image (100 kB) now and then that no requirement reads, and small messages, which all are judged: every
other one is a signal, the others are a message and a signal. They are CDR as of ROS 2, or JSON. Rates are beside those
of the libraries that only decode the same messages (`rosbags`, `json`): the ratio is nearly the same on a busy machine.
Each log is checked in a process of its own, whose memory is measured.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import resource
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from mcap.writer import CompressionType, Writer

from pytest_hricdv.extra.logs.judging import judge
from pytest_hricdv.extra.logs.log_map import LogMap, MessageSource, SignalSource
from pytest_hricdv.extra.logs.logged_run import LogReader
from pytest_hricdv.monitor import Requirement, Vocabulary, parse_formula
from pytest_hricdv.recordings.bags import Decoder
from pytest_hricdv.recordings.containers import read_mcap
from pytest_hricdv.recordings.recording import recording_readers
from studies.session import machine
from tests.recordings.bags import DEFINITIONS, tray

VOCABULARY = Vocabulary(signals={"x": float, "wet": bool}, messages={"tray": {"cups": float}})
FORMULAS = (
    "always(on(tray) & tray.cups > 2 -> eventually[0:1](wet))",
    "always(x > 0.5 -> x < 12)",
    "always(rise(wet) -> eventually[0:2](not wet))",
)
MAP = LogMap(
    messages={"tray": MessageSource(topic="/tray")},
    signals={"x": SignalSource(topic="/arm", value="pose.x"), "wet": SignalSource(topic="/tray", value="is_wet")},
)
TOPICS = ("/arm", "/tray")
IMAGE = 100_000
KINDS = ("cdr", "json")


def write_log(file: Path, kind: str, events: int, size: int) -> None:
    """Write a log with so many events and, in images, the rest of its size (bytes)."""
    images = max(0, size - 120 * events) // IMAGE
    with file.open("wb") as stream:
        writer = Writer(stream, compression=CompressionType.NONE if size else CompressionType.ZSTD)
        writer.start(profile="ros2")
        schema = writer.register_schema("cell_msgs/msg/Tray", "ros2msg", DEFINITIONS["cell_msgs/msg/Tray"].encode())
        small = [writer.register_channel(topic, kind, schema) for topic in TOPICS]
        image = writer.register_channel("/image", "cdr", 0)
        shown = 0
        for number in range(events):
            time_ns, values = 10**18 + number * 1_000_000, (float(number % 97) / 9, 1.5, number // 2 % 4, [0.5, 1.5])
            is_wet = number // 500 % 2 == 1
            if kind == "cdr":
                data = tray(*values, is_wet)
            else:
                x, y, cups, loads = values
                content = {"pose": {"x": x, "y": y}, "cups": cups, "loads": loads, "is_wet": is_wet}
                data = json.dumps(content).encode()
            writer.add_message(small[number % 2], time_ns, data, time_ns)
            while shown * events < images * number:
                shown += 1
                writer.add_message(image, time_ns, bytes(IMAGE), time_ns)
        writer.finish()  # type: ignore[no-untyped-call]


def check(file: Path) -> tuple[float, float, int]:
    """Processor time (s), greatest memory (MB) and events of a check."""
    requirements = [
        Requirement(f"R{n}", "", "", text, parse_formula(text, VOCABULARY)) for n, text in enumerate(FORMULAS, 1)
    ]
    began_s = time.process_time()
    (recording,) = recording_readers([file], lambda kind: None)
    (judged,) = judge(LogReader(recording, MAP, VOCABULARY), requirements)
    spent_s = time.process_time() - began_s
    assert [verdict.verdict for verdict in judged.verdicts.values()] == ["Passed"] * 3
    return (
        spent_s,
        resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        sum(judged.run.topics[topic].count for topic in TOPICS),
    )


def decode(file: Path) -> float:
    """Processor time (s) for decoding its messages alone."""
    messages = [message for message in read_mcap(file) if message.topic.name in TOPICS]
    decoder = Decoder(lambda kind: None)
    began_s = time.process_time()
    if messages[0].topic.encoding == "json":
        for message in messages:
            json.loads(message.data)
    else:
        for message in messages:
            decoder._content(message)
    return time.process_time() - began_s


def rows(options: argparse.Namespace, folder: Path) -> Iterator[str]:
    """A line for each kind of messages, and for each size."""
    context = multiprocessing.get_context("spawn")
    for kind in KINDS:
        file = folder / f"{kind}.mcap"
        write_log(file, kind, options.events, 0)
        with context.Pool(1) as pool:
            spent_s, peak_mb, events = pool.apply(check, (file,))
        ratio = spent_s / decode(file)
        rate = f"{kind:8} {events:>10,} events {events / spent_s:8,.0f} a second"
        yield f"{rate}  {ratio:5.2f} times decoding  {peak_mb:6.0f} MB"
        file.unlink()
    for megabytes in options.megabytes:
        file = folder / "large.mcap"
        write_log(file, "cdr", megabytes * options.density, megabytes * 1_000_000)
        with context.Pool(1) as pool:
            spent_s, peak_mb, events = pool.apply(check, (file,))
        yield f"{megabytes:6} MB {events:>10,} events {events / spent_s:8,.0f} a second  {peak_mb:6.0f} MB of memory"
        file.unlink()


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--events", type=int, default=500_000, metavar="N", help="of the logs by kind (500,000)")
    parser.add_argument("--megabytes", type=int, nargs="*", default=[100, 1000], metavar="N", help="sizes (100 1000)")
    parser.add_argument("--density", type=int, default=500, metavar="N", help="events a megabyte of these (500)")
    options = parser.parse_args()
    print(f"machine: {machine()}")
    with TemporaryDirectory() as folder:
        for row in rows(options, Path(folder)):
            print(row, flush=True)


if __name__ == "__main__":
    main()
