"""A trace of a run as an MCAP file (https://mcap.dev/spec): JSON messages with JSON Schemas, in virtual time.

`TraceWriter` calls `write` with a `McapTrace`. The file contains the messages, signals and disturbances of the record,
the verdicts, actions and plans, and the scene. The same run gives the same bytes: times are those of the run, from 0
on, and the file contains neither the machine's name nor the date.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer
from msgspec import to_builtins

from pytest_hricdv._base import atomic_file
from pytest_hricdv.extra.traces import schemas
from pytest_hricdv.extra.traces.records import SceneChange
from pytest_hricdv.generate.actors import act_of, actor_of
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.runtime import Record
from pytest_hricdv.runtime.world import Body
from pytest_hricdv.testbench import Testbench

LIBRARY = "pytest-hricdv"
NS_PER_US, US_PER_S = 1000, 1_000_000


@dataclass(frozen=True)
class Channel:
    """A topic with its schema. Messages of two senders are two channels of one topic, as in ROS.

    Args:
        schema: the name and the JSON Schema of its messages.
        metadata: names and values that apply to all of its messages.
    """

    topic: str
    schema: tuple[str, Mapping[str, Any]] = field(hash=False, compare=False)
    metadata: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class TraceEvent:
    """One message of a channel: its time (ns of virtual time), and its content as JSON."""

    channel: Channel
    time_ns: int
    content: Mapping[str, Any]


@dataclass(frozen=True)
class McapTrace:
    """A run to be written.

    Args:
        testbench: declares the types and units.
        scene: how the shapes of the world moved; empty where nothing is known of them.
    """

    test: TestResult
    record: Record
    testbench: Testbench
    scene: Sequence[SceneChange] = ()

    @property
    def facts(self) -> dict[str, str]:
        """What the run is, name -> text."""
        test = self.test
        return {
            "testbench": self.testbench.name,
            "test": test.id,
            "suite": test.suite,
            "seed": str(test.seed),
            "engine": test.engine,
            "ended": test.end_reason,
            "outcomes": ", ".join(test.outcomes),
            "record_sha256": self.record.sha256,
            "beliefs": ", ".join(test.beliefs),
            **{f"plans of {agent}": ", ".join(plans) for agent, plans in sorted(test.plans.items())},
            **{f"verdict of {name}": judged.verdict for name, judged in sorted(test.requirements.items())},
        }

    def events(self) -> list[TraceEvent]:
        """All events in the order of time; within an instant in the order of this module."""
        parts = (
            self._scene(),
            self._signals(),
            self._messages(),
            self._acts(),
            self._violations(),
            self._cross(),
            self._end(),
        )
        # A stable sort, so that those of one instant keep the order of the parts.
        return sorted(chain.from_iterable(parts), key=lambda event: event.time_ns)

    def _messages(self) -> Iterator[TraceEvent]:
        described = schemas.describe_messages(self.testbench)
        for message in self.record.messages:
            if message.is_disturbance:
                text = f"{message.topic} {_words(message.fields)}".rstrip()
                yield _log(message.time_s, schemas.WARNING, "disturbance", text)
                channel = Channel("/hricdv/disturbances", schemas.DISTURBANCE, (("sender", message.sender),))
                content = {"event": message.topic, "fields": dict(message.fields)}
                yield TraceEvent(channel, ns(message.time_s), content)
                continue
            schema = described.get(message.topic) or schemas.describe_fields(
                f"{self.testbench.name}.{message.topic}", message.fields
            )
            type_name = getattr(message.source, "type", None)  # of a message of ROS 2
            ros = (("ros_type", str(type_name)),) if type_name else ()
            channel = Channel(f"/{message.topic}", schema, (("sender", message.sender), *ros))
            yield TraceEvent(channel, ns(message.time_s), dict(message.fields))

    def _signals(self) -> Iterator[TraceEvent]:
        declared, units = self.testbench.signal_types, self.testbench.units
        for name, (times, values) in self.record.signals.items():
            kind = bool if declared.get(name) is bool else float
            channel = Channel(f"/signals/{name}", schemas.describe_signal(name, kind, units.get(name, "")))
            for time_s, value in zip(times, values, strict=True):
                yield TraceEvent(channel, ns(time_s), {"value": kind(value)})
        for name, (times, texts) in self.record.texts.items():
            channel = Channel(f"/signals/{name}", schemas.describe_signal(name, str, ""))
            for time_s, text in zip(times, texts, strict=True):
                yield TraceEvent(channel, ns(time_s), {"value": text})

    def _acts(self) -> Iterator[TraceEvent]:
        for time_s, number in self.test.action_starts:
            action = self.test.concrete.actions[number]
            who = actor_of(action.command) or "test"
            yield _log(time_s, schemas.INFO, who, f"{act_of(action.command)} {_words(action.parameters)}".rstrip())
        for time_s, line in self.test.bystander_events:
            yield _log(time_s, schemas.INFO, actor_of(line), act_of(line))

    def _violations(self) -> Iterator[TraceEvent]:
        channel = Channel("/hricdv/violations", schemas.VIOLATION)
        for name, judged in self.test.requirements.items():
            for violation in judged.violations:
                yield TraceEvent(channel, ns(violation.time_s), {"requirement": name, **to_builtins(violation)})
                yield _log(violation.time_s, schemas.ERROR, name, f"violated: {_words(violation.values)}".rstrip(": "))

    def _cross(self) -> Iterator[TraceEvent]:
        """The hits of cross products, which are known when the run has ended."""
        for name, hits in (self.test.cross or {}).items():
            coordinates = self.testbench.cross[name].coordinates
            for hit in hits:
                content = {"product": name, "bin": dict(zip(coordinates, hit, strict=True))}
                yield TraceEvent(Channel("/hricdv/cross", schemas.CROSS), ns(self.test.sim_s), content)

    def _end(self) -> Iterator[TraceEvent]:
        verdicts = {name: judged.verdict for name, judged in self.test.requirements.items()}
        content = {"ended": self.test.end_reason, "outcomes": list(self.test.outcomes), "verdicts": verdicts}
        yield TraceEvent(Channel("/hricdv/end", schemas.END), ns(self.test.sim_s), content)

    def _scene(self) -> Iterator[TraceEvent]:
        channel = Channel("/hricdv/scene", schemas.SCENE_UPDATE)
        for change in self.scene:
            stamp = _stamp(change.time_us * NS_PER_US)
            content = {
                "deletions": [{"timestamp": stamp, "type": 0, "id": name} for name in change.gone],
                "entities": [_entity(body, stamp) for body in change.moved],
            }
            yield TraceEvent(channel, change.time_us * NS_PER_US, content)


def write(path: Path, trace: McapTrace) -> None:
    """Write a trace.

    Raises:
        OSError: the file cannot be written; an old one is left as it was.
    """
    with atomic_file.replace_file(path) as temporary, temporary.open("wb") as file:
        writer = Writer(file, compression=CompressionType.LZ4)
        writer.start(library=LIBRARY)
        writer.add_metadata("hricdv", trace.facts)
        schemas: dict[str, int] = {}
        numbers: dict[Channel, int] = {}
        for event in trace.events():
            channel = event.channel
            if channel not in numbers:
                name, schema = channel.schema
                if name not in schemas:
                    schemas[name] = writer.register_schema(name, "jsonschema", json.dumps(schema).encode())
                numbers[channel] = writer.register_channel(channel.topic, "json", schemas[name], dict(channel.metadata))
            # A text of the code under test may have half a surrogate pair, which UTF-8 has no bytes for.
            data = json.dumps(event.content, ensure_ascii=False).encode("utf-8", "backslashreplace")
            writer.add_message(numbers[channel], event.time_ns, data, event.time_ns)
        writer.finish()  # type: ignore[no-untyped-call]


def ns(time_s: float) -> int:
    """A time of the record (s) in ns; the kernel counts microseconds."""
    return round(time_s * US_PER_S) * NS_PER_US


def _stamp(time_ns: int) -> dict[str, int]:
    return {"sec": time_ns // 1_000_000_000, "nsec": time_ns % 1_000_000_000}


def _log(time_s: float, level: int, name: str, text: str) -> TraceEvent:
    content = {"timestamp": _stamp(ns(time_s)), "level": level, "message": text, "name": name, "file": "", "line": 0}
    return TraceEvent(Channel("/hricdv/log", schemas.LOG), ns(time_s), content)


def _words(values: Mapping[str, object]) -> str:
    return ", ".join(f"{name} = {value}" for name, value in values.items())


def _entity(body: Body, stamp: dict[str, int]) -> dict[str, Any]:
    """A `foxglove.SceneEntity` with one shape."""
    shape: dict[str, Any] = {
        "pose": {
            "position": dict(zip("xyz", body.position_m, strict=True)),
            "orientation": dict(zip("xyzw", body.rotation, strict=True)),
        },
        "size": dict(zip("xyz", body.size_m, strict=True)),
        "color": dict(zip("rgba", body.rgba, strict=True)),
    }
    if body.shape == "cylinder":
        shape |= {"bottom_scale": 1.0, "top_scale": 1.0}
    key = {"box": "cubes", "sphere": "spheres", "cylinder": "cylinders"}[body.shape]
    return {
        "timestamp": stamp,
        "frame_id": "world",
        "id": body.name,
        "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": True,
        "metadata": [],
        **{kind: [shape] if kind == key else [] for kind in schemas.PRIMITIVES},
    }
