"""JSON Schemas of the channels in `mcap_trace`. Those that viewers know have the viewers' names, as `foxglove.Log`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pytest_hricdv.runtime.record import Value
from pytest_hricdv.testbench import Testbench

Schema = tuple[str, Mapping[str, Any]]
"""The name of a schema, and the JSON Schema itself."""

INFO, WARNING, ERROR = 2, 3, 4
"""Levels of `foxglove.Log`."""

PRIMITIVES = ("arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models")
"""The kinds of shapes of a `foxglove.SceneEntity`."""

_TYPES: dict[type, str] = {bool: "boolean", float: "number", str: "string"}


def describe_messages(testbench: Testbench) -> dict[str, Schema]:
    """Topic -> the schema of its messages, with units where they are declared."""
    vocabulary = testbench.vocabulary()
    schemas: dict[str, Schema] = {}
    for topic, fields in vocabulary.messages.items():
        properties = {
            name: _property(kind, vocabulary.units.get(f"{topic}.{name}", "")) for name, kind in fields.items()
        }
        schemas[topic] = (f"{testbench.name}.{topic}", _object(properties))
    return schemas


def describe_fields(name: str, fields: Mapping[str, Value]) -> Schema:
    """The schema of messages like this one, of a topic that the testbench does not declare."""
    kinds = {field: type(value) if isinstance(value, bool | str) else float for field, value in fields.items()}
    return name, _object({field: _property(kind, "") for field, kind in kinds.items()})


def describe_signal(name: str, kind: type, unit: str) -> Schema:
    """The schema of a signal: its value from then on."""
    return f"signal.{name}", _object({"value": _property(kind, unit)})


def _property(kind: type, unit: str) -> dict[str, Any]:
    return {"type": _TYPES[kind], **({"description": f"in {unit}"} if unit else {})}


def _object(properties: Mapping[str, Any]) -> dict[str, Any]:
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "type": "object", "properties": properties}


def _list(of: Mapping[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": of}


_NUMBER, _INTEGER, _TEXT = {"type": "number"}, {"type": "integer"}, {"type": "string"}
_TIME = {"type": "object", "title": "time", "properties": {"sec": _INTEGER, "nsec": _INTEGER}}
_DURATION = {**_TIME, "title": "duration"}
_VECTOR = {"type": "object", "properties": dict.fromkeys("xyz", _NUMBER)}
_POSE = {
    "type": "object",
    "properties": {
        "position": _VECTOR,
        "orientation": {"type": "object", "properties": dict.fromkeys("xyzw", _NUMBER)},
    },
}
_SHAPE = {
    "type": "object",
    "properties": {
        "pose": _POSE,
        "size": _VECTOR,
        "bottom_scale": _NUMBER,
        "top_scale": _NUMBER,
        "color": {"type": "object", "properties": dict.fromkeys("rgba", _NUMBER)},
    },
}

LOG: Schema = (
    "foxglove.Log",
    _object({"timestamp": _TIME, "level": _INTEGER, "message": _TEXT, "name": _TEXT, "file": _TEXT, "line": _INTEGER}),
)

SCENE_UPDATE: Schema = (
    "foxglove.SceneUpdate",
    _object(
        {
            "deletions": _list(_object({"timestamp": _TIME, "type": _INTEGER, "id": _TEXT})),
            "entities": _list(
                _object(
                    {
                        "timestamp": _TIME,
                        "frame_id": _TEXT,
                        "id": _TEXT,
                        "lifetime": _DURATION,
                        "frame_locked": {"type": "boolean"},
                        "metadata": _list(_object({"key": _TEXT, "value": _TEXT})),
                        **{name: _list(_SHAPE) for name in PRIMITIVES},
                    }
                )
            ),
        }
    ),
)

VIOLATION: Schema = (
    "hricdv.Violation",
    _object({"requirement": _TEXT, "time_s": _NUMBER, "trigger_s": {}, "values": {"type": "object"}}),
)

DISTURBANCE: Schema = ("hricdv.Disturbance", _object({"event": _TEXT, "fields": {"type": "object"}}))

CROSS: Schema = ("hricdv.CrossHit", _object({"product": _TEXT, "bin": {"type": "object"}}))

END: Schema = (
    "hricdv.End",
    _object({"ended": _TEXT, "outcomes": _list(_TEXT), "verdicts": {"type": "object"}}),
)
