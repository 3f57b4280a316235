"""Which topic and field of a log is which message and signal of the testbench: `map.toml`, or a draft of one."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Literal

from msgspec import ValidationError, convert

from pytest_hricdv._base.input_file import MAX_TOML_BYTES, MalformedError, check_keys_of, from_toml, read_text
from pytest_hricdv._base.message import InputError, quote
from pytest_hricdv._base.record import PlainRecord
from pytest_hricdv._base.suggestion import nearest
from pytest_hricdv.coverage.cross_product import CrossProduct
from pytest_hricdv.extra.logs.expression import parse_expression
from pytest_hricdv.monitor.units import unit_of
from pytest_hricdv.monitor.vocabulary import Vocabulary
from pytest_hricdv.recordings.bags import Value

PLACE = re.compile(r"\{([^{}]*)\}")
"""A field in the command of an action."""

Clock = Literal["log", "header"]
"""Whose times count: when a message was recorded, or the stamp in its header."""


class FieldSource(PlainRecord, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where a value is in a message of the log, and how it becomes that of the testbench.

    Attributes:
        path: of the field, with dots.
        expression: instead of one: numbers of several fields, as `hypot(speed.x, speed.y)`.
        unit: that it has in the log; it becomes the declared one.
        scale: what it is multiplied by; with `offset` added.
        equals: of a truth: the value for which it is true.
    """

    path: str = ""
    expression: str = ""
    unit: str = ""
    scale: float = 1.0
    offset: float = 0.0
    equals: str | float | bool | None = None


class TopicSource(PlainRecord, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A topic of the log, whose times count, and for how long (s) it may have no data."""

    topic: str
    time: Clock | None = None
    gap_s: float | None = None


class MessageSource(TopicSource, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A message of the testbench: its topic in the log, and its fields; those without a source have its path."""

    fields: Mapping[str, str | FieldSource] = {}


class SignalSource(TopicSource, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A signal of the testbench: a topic in the log, and which of its fields.

    Attributes:
        every_s: of the values within so much time (s), only the first one counts; None: all count.
    """

    value: str | FieldSource
    every_s: float | None = None


class CrossSource(TopicSource, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Hits of a cross product: the topic whose messages are one each, with the bins of its coordinates.

    Attributes:
        coordinates: coordinate -> where its bin is, a text; those named after requirements are filled in from verdicts.
        only: as of `ActionSource`.
    """

    coordinates: Mapping[str, str]
    only: Mapping[str, str | float | bool] = {}


class ActionSource(TopicSource, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """An action of a person: the topic whose messages say that it begins.

    Attributes:
        command: as the testbench has it; `{path}` stands for a field of the message.
        only: field -> the value that it must have, where other messages of the topic are no such action.
        since: its parameter that is the time (s) since the action before, or since the log began.
        parameters: others of its parameters -> where they are in the message.
    """

    command: str
    only: Mapping[str, str | float | bool] = {}
    since: str = ""
    parameters: Mapping[str, str | FieldSource] = {}

    @property
    def parameter_sources(self) -> dict[str, FieldSource]:
        """Parameter -> where it is."""
        return {name: _source(value) for name, value in self.parameters.items()}


class LogMap(PlainRecord, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Topics and fields of a log as messages and signals of the testbench.

    Attributes:
        time: whose times count, where a message or signal does not say.
        gap_s: no data for longer (s) is a gap, likewise; None: five times the period of a periodic topic.
        actions: what people do, for tests of a log; their names are for people.
        cross: cross product -> its hits.
    """

    time: Clock = "log"
    gap_s: float | None = None
    messages: Mapping[str, MessageSource] = {}
    signals: Mapping[str, SignalSource] = {}
    actions: Mapping[str, ActionSource] = {}
    cross: Mapping[str, CrossSource] = {}

    @property
    def is_own(self) -> bool:
        """Whether it is that of a trace of this tool, whose time neither jumps nor has gaps; no file can say so."""
        return self.gap_s == math.inf

    @property
    def sources(self) -> dict[str, TopicSource]:
        """Message or signal -> its topic."""
        return {**self.messages, **self.signals}


def read_map(path: Path, vocabulary: Vocabulary, products: Mapping[str, CrossProduct] | None = None) -> LogMap:
    """The map of a file.

    Args:
        path: of the file.
        vocabulary: of the testbench.
        products: its cross products; None where they are of no interest.

    Raises:
        InputError: there is none, it is no map, or it names what the testbench does not declare.
    """
    try:
        tables = from_toml(read_text(path, MAX_TOML_BYTES))
        check_keys_of(LogMap, tables)  # names the nearest one
        made = convert(tables, LogMap)
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file") from None
    except MalformedError as error:
        raise InputError(f"{path}{error}") from None
    except ValidationError as error:
        raise InputError(f"{path}: {error}") from None
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
    for name, source in field_sources(made, vocabulary):
        if source.path and source.expression:
            yield f"{name}: expected either a path or an expression"
        elif source.expression:
            yield from parse_expression(source.expression).problems(name)
        declared = vocabulary.unit(name)
        if source.unit and (declared is None or unit_of(source.unit).dimension != declared.dimension):
            yield f"{name}: its unit is {vocabulary.units.get(name) or 'not declared'}, which is none of {source.unit}"


def field_sources(made: LogMap, vocabulary: Vocabulary) -> Iterator[tuple[str, FieldSource]]:
    """Each signal, and each field as `message.field`, with where it is."""
    for name, message in made.messages.items():
        for field in vocabulary.messages.get(name, {}):
            yield f"{name}.{field}", _source(message.fields.get(field, field))
    for name, signal in made.signals.items():
        yield name, _source(signal.value)


def _source(value: str | FieldSource) -> FieldSource:
    return FieldSource(path=value) if isinstance(value, str) else value


def _problems_of_cross(made: LogMap, products: Mapping[str, CrossProduct] | None) -> Iterator[str]:
    for name, source in made.cross.items() if products is not None else ():
        if name not in (products or {}):
            yield f"cross.{name}: the testbench has no such cross product{nearest(name, products or {})}"
            continue
        for coordinate in source.coordinates.keys() - (products or {})[name].coordinates.keys():
            yield f"cross.{name}.coordinates.{coordinate}: it has no such coordinate"


Reading = Callable[[Mapping[str, Value]], Value]
"""Takes a value from the fields of a message."""


def paths_of(source: FieldSource) -> tuple[str, ...]:
    """The fields that it reads."""
    return parse_expression(source.expression).names if source.expression else (source.path,)


def reading_of(name: str, source: FieldSource, vocabulary: Vocabulary) -> Reading:
    """What takes the value of a signal, or of a field as `message.field`, from messages of the log.

    It raises InputError where a message lacks the value, or it is of another type.
    """
    kind, declared, path = vocabulary.kind(name), vocabulary.unit(name), source.path
    factor = float(unit_of(source.unit).scale / declared.scale) if source.unit and declared else 1.0
    factor, offset, equals = factor * source.scale, source.offset, source.equals
    expression = parse_expression(source.expression) if source.expression else None

    def read(fields: Mapping[str, Value]) -> Value:
        value = fields.get(path) if expression is None else expression.value(name, fields)
        if kind is float and type(value) is float and equals is None:
            return value * factor + offset
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


def number_of(name: str, source: FieldSource, fields: Mapping[str, Value]) -> float:
    """A number in a message of the log. Raises InputError where it is none."""
    value = fields.get(source.path)
    if source.unit or source.equals is not None:
        raise InputError(f"{name}: expected a path, scale and offset only; a parameter's unit is in its name")
    if isinstance(value, bool) or not isinstance(value, float):
        raise InputError(f"{name}: {source.path} is {quote(value)}; expected a number{nearest(source.path, fields)}")
    return value * source.scale + source.offset


def of_own_trace(
    topics: Mapping[str, str], vocabulary: Vocabulary, products: Mapping[str, CrossProduct] | None = None
) -> LogMap:
    """The map of a file of `--hri-mcap`."""
    crosses = {
        name: CrossSource(
            topic="/hricdv/cross",
            only={"product": name},
            coordinates={coordinate: f"bin.{coordinate}" for coordinate in product.coordinates},
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
    """The lines of a map: what has the same name is filled in, all else is listed.

    Args:
        fields: topic -> the fields of its messages.
        vocabulary: of the testbench.
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
    """What has this name, or the only one that ends with it; empty if there is none."""
    if name in keys:
        return keys[name]
    ends = [value for key, value in keys.items() if key.endswith((f"_{name}", f".{name}"))]
    return ends[0] if len(ends) == 1 else ""
