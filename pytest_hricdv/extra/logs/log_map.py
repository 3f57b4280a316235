"""`LogMap`: maps topics and fields of a log to messages and signals of the testbench.

`hricdv check` reads it from `map.toml` with `read_map`, or drafts one from the topics of a log with `draft_map`.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Literal

import msgspec

from pytest_hricdv._base.input_file import read_toml
from pytest_hricdv._base.message import InputError, nearest, quote
from pytest_hricdv._base.record import PlainRecord
from pytest_hricdv.coverage.cross_product import CrossProduct
from pytest_hricdv.extra.logs.expression import parse_expression
from pytest_hricdv.monitor.node import Kind
from pytest_hricdv.monitor.units import Unit, unit_of
from pytest_hricdv.monitor.vocabulary import Vocabulary
from pytest_hricdv.recordings.bags import Value

PLACE = re.compile(r"\{([^{}]*)\}")
"""A placeholder for a field, in braces, in the command of an action."""

Period = Annotated[float, msgspec.Meta(gt=0)]
"""A duration (s) above 0, perhaps infinite."""

Clock = Literal["log", "header"]
"""Which time a message has: when it was recorded, or the stamp in its header."""


class FieldSource(PlainRecord, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The source of a value in a message of the log, and its conversion.

    Attributes:
        path: the field's path, with dots.
        expression: instead of a path, a number computed from fields, such as `hypot(speed.x, speed.y)`.
        unit: the unit of the value in the log; it is converted to the declared unit.
        equals: for a truth value: the value of the field for which it is true.
    """

    path: str = ""
    expression: str = ""
    unit: str = ""
    equals: str | float | bool | None = None


class TopicSource(PlainRecord, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A topic of the log.

    Attributes:
        time: the clock of its messages; None for that of the map.
        gap_s: longest time (s) without data that is not a gap; None for that of the map.
        only: field -> the value that it must have; other messages are ignored.
    """

    topic: str
    time: Clock | None = None
    gap_s: Period | None = None
    only: Mapping[str, str | float | bool] = {}


class MessageSource(TopicSource, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A message of the testbench: its topic in the log, and its fields. A field that is not listed keeps its name."""

    fields: Mapping[str, str | FieldSource] = {}


class SignalSource(TopicSource, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A signal of the testbench: a topic in the log, and one of its fields.

    Attributes:
        every_s: period (s) of resampling: the first value of each period counts; None: all values count.
    """

    value: str | FieldSource
    every_s: Period | None = None


class CrossSource(TopicSource, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A cross product: each message of the topic is a hit.

    Attributes:
        coordinates: coordinate -> the field with its bin. Coordinates named after requirements come from verdicts.
    """

    coordinates: Mapping[str, str]


class ActionSource(TopicSource, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """An action of a person: it begins with each message of the topic.

    Attributes:
        command: as the testbench has it; `{path}` stands for a field of the message.
        since: the parameter that is the time (s) since the previous action, or since the beginning of the log.
        parameters: other parameters -> their sources.
    """

    command: str
    since: str = ""
    parameters: Mapping[str, str | FieldSource] = {}


class LogMap(PlainRecord, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Maps topics and fields of a log to messages and signals of the testbench.

    Attributes:
        time: the clock of all topics that do not name one.
        gap_s: likewise, the longest time (s) without data that is not a gap; None: five periods of a periodic topic.
        actions: the actions of people, for tests of a log, by names that only people read.
        cross: cross product -> its hits.
    """

    time: Clock = "log"
    gap_s: Period | None = None
    messages: Mapping[str, MessageSource] = {}
    signals: Mapping[str, SignalSource] = {}
    actions: Mapping[str, ActionSource] = {}
    cross: Mapping[str, CrossSource] = {}

    @property
    def is_own(self) -> bool:
        """Whether it is that of a trace of this tool: no gaps, no jumps of the clock. No file can declare that."""
        return self.gap_s == math.inf

    @property
    def sources(self) -> dict[str, TopicSource]:
        """Message or signal -> its topic."""
        return {**self.messages, **self.signals}


def read_map(path: Path, vocabulary: Vocabulary, products: Mapping[str, CrossProduct] | None = None) -> LogMap:
    """The map of a file.

    Args:
        products: the testbench's cross products; None to ignore them.

    Raises:
        InputError: the file does not exist, it is not a map, or it names something that the testbench does not declare.
    """
    made = read_toml(path, LogMap)
    for problem in (*_problems(made, vocabulary), *_problems_of_cross(made, products)):
        raise InputError(f"{path}: {problem}")
    return made


def _problems(made: LogMap, vocabulary: Vocabulary) -> Iterator[str]:
    for name, message in made.messages.items():
        if name not in vocabulary.messages:
            yield f"messages.{name}: the testbench has no such message{nearest(name, vocabulary.messages)}"
        for field in message.fields:
            if field not in vocabulary.messages.get(name, {}):
                yield f"messages.{name}.fields.{field}: the message has no such field"
    for name in made.signals:
        if name not in vocabulary.signals:
            yield f"signals.{name}: the testbench has no such signal{nearest(name, vocabulary.signals)}"
    for name, source in _fields(made, vocabulary):
        if source.path and source.expression:
            yield f"{name}: expected either a path or an expression"
        elif source.expression:
            yield from parse_expression(source.expression).problems(name)
        declared = vocabulary.unit(name)
        if source.unit and (declared is None or unit_of(source.unit).dimension != declared.dimension):
            unit = vocabulary.units.get(name) or "not declared"
            yield f"{name}: its unit is {unit}, to which {source.unit} cannot be converted"
        if source.equals is not None and vocabulary.kind(name) is not bool:
            yield f"{name}: equals is for truth values only"


def _fields(made: LogMap, vocabulary: Vocabulary) -> Iterator[tuple[str, FieldSource]]:
    for name, topic in made.sources.items():
        yield from field_sources(name, topic, vocabulary)
    for name, action in made.actions.items():
        for parameter, value in action.parameters.items():
            yield f"actions.{name}.parameters.{parameter}", source_of(value)


def field_sources(name: str, topic: TopicSource, vocabulary: Vocabulary) -> Iterator[tuple[str, FieldSource]]:
    """The source of a signal, or those of the fields of a message as `message.field`."""
    if isinstance(topic, SignalSource):
        yield name, source_of(topic.value)
    elif isinstance(topic, MessageSource):
        for field in vocabulary.messages.get(name, {}):
            yield f"{name}.{field}", source_of(topic.fields.get(field, field))


def source_of(value: str | FieldSource) -> FieldSource:
    """A source; a text is a path."""
    return FieldSource(path=value) if isinstance(value, str) else value


def _problems_of_cross(made: LogMap, products: Mapping[str, CrossProduct] | None) -> Iterator[str]:
    for name, source in made.cross.items() if products is not None else ():
        if name not in (products or {}):
            yield f"cross.{name}: the testbench has no such cross product{nearest(name, products or {})}"
            continue
        for coordinate in source.coordinates.keys() - (products or {})[name].coordinates.keys():
            yield f"cross.{name}.coordinates.{coordinate}: no such coordinate"


Reading = Callable[[Mapping[str, Value]], Value]
"""Takes a value from the fields of a message."""


def paths_of(source: FieldSource) -> tuple[str, ...]:
    """The fields that it reads."""
    return parse_expression(source.expression).names if source.expression else (source.path,)


def reading_of(name: str, source: FieldSource, kind: Kind | None, declared: Unit | None = None) -> Reading:
    """A function that takes a value from messages of the log.

    It raises InputError if a message lacks the value, or has one of another type.

    Args:
        name: the name of the value, for errors.
        source: the source in the message.
        kind: type of the value; None if the testbench does not declare it.
        declared: its unit.
    """
    path, equals = source.path, source.equals
    factor = float(unit_of(source.unit).scale / declared.scale) if source.unit and declared else 1.0
    expression = parse_expression(source.expression) if source.expression else None

    def read(fields: Mapping[str, Value]) -> Value:
        value = fields.get(path) if expression is None else expression.value(name, fields)
        if kind is float and type(value) is float and equals is None:
            return value * factor
        if value is None:
            raise InputError(f"{name}: its messages have no field {path}{nearest(path, fields)}")
        if equals is not None:
            return value == equals
        if kind is bool and value in (0.0, 1.0):
            return bool(value)
        if kind is None or not isinstance(value, kind):
            wanted = "nothing" if kind is None else kind.__name__
            raise InputError(f"{name}: {path} is {quote(value)}; expected a {wanted}")
        return value

    return read


def map_own_trace(
    topics: Mapping[str, str],
    vocabulary: Vocabulary,
    products: Mapping[str, CrossProduct] | None = None,
    requirements: Collection[str] = (),
) -> LogMap:
    """The map of a file of `--hri-mcap`; coordinates named after these requirements come from verdicts."""
    crosses = {
        name: CrossSource(
            topic="/hricdv/cross",
            only={"product": name},
            coordinates={key: f"bin.{key}" for key in product.coordinates if key not in requirements},
        )
        for name, product in (products or {}).items()
    }
    return LogMap(
        cross=crosses,
        gap_s=math.inf,
        messages={name: MessageSource(topic=f"/{name}") for name in vocabulary.messages if f"/{name}" in topics},
        signals={name: SignalSource(topic=f"/signals/{name}", value="value") for name in vocabulary.signals
                 if f"/signals/{name}" in topics},
    )  # fmt: skip


def draft_map(fields: Mapping[str, Mapping[str, Value]], vocabulary: Vocabulary) -> Iterator[str]:
    """The lines of a map: topics and fields with equal names are filled in, the others are listed.

    Args:
        fields: topic -> the fields of its messages.
    """
    yield 'time = "log"  # or "header": the stamp in the header of each message'
    keys = {topic.strip("/").replace("/", "_"): topic for topic in fields}
    for name, kinds in vocabulary.messages.items():
        topic = _similar(name, keys)
        yield f"\n[messages.{name}]\ntopic = {json.dumps(topic)}{'' if topic else '  # TODO'}"
        for field in kinds:
            path = _similar(field, {path: path for path in fields.get(topic, {})})
            yield f"fields.{json.dumps(field)} = {json.dumps(path)}{'' if path else '  # TODO'}"
    for name in vocabulary.signals:
        topic, unit = _similar(name, keys), vocabulary.units.get(name, "")
        path = next(iter(fields.get(topic, {})), "")
        note = f"  # in {unit}; of another unit: {{ path = ..., unit = ... }}" if unit else ""
        yield f"\n[signals.{name}]\ntopic = {json.dumps(topic)}{'' if topic else '  # TODO'}"
        yield f"value = {json.dumps(path)}{note if path else '  # TODO'}"
    yield "\n# the log has:"
    for topic in sorted(fields):
        yield f"# {topic}: {', '.join(sorted(fields[topic])) or 'no field that can be compared'}"


def _similar(name: str, keys: Mapping[str, str]) -> str:
    """The value of this key, or of the only one that ends with it; empty if there is none."""
    if name in keys:
        return keys[name]
    ends = [value for key, value in keys.items() if key.endswith((f"_{name}", f".{name}"))]
    return ends[0] if len(ends) == 1 else ""
