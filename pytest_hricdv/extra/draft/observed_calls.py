"""Makes messages of the calls at the code's ports, one for each method or observed topic, for use in requirements.

It also makes the ports of modules that are not installed, from what first runs observed at their stand-ins.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from pytest_hricdv.extra.draft.code.flow import Flow
from pytest_hricdv.extra.draft.code.handovers import last_part
from pytest_hricdv.extra.draft.code.naming import camel, snake, unit_of, word
from pytest_hricdv.extra.draft.code_model import (
    OWN_MODULE,
    CodeLine,
    Entry,
    FieldValue,
    Message,
    MessageField,
    Operation,
    Port,
)
from pytest_hricdv.extra.draft.observe.observations import Observations, Site
from pytest_hricdv.extra.draft.observe.shape import MASK, Shape
from pytest_hricdv.extra.draft.observe.tracer import CALLBACK
from pytest_hricdv.extra.draft.stand_ins.border import ANSWER
from pytest_hricdv.extra.draft.stand_ins.connections import SENDS
from pytest_hricdv.extra.draft.stand_ins.parts import without_arguments

LOGS = {"debug", "info", "warning", "warn", "error", "exception", "critical", "log", "setLevel"}
"""Methods of loggers: drafts make no messages of calls to them."""

CHANNELS = ("queue", "publish", "bus")
"""Roles of ports that only hand messages on."""

MAX_TOLD = 12
"""Most messages for the calls at a port."""


def messages_for_calls(port: Port, entry: Entry, seen: Observations, flow: Flow) -> Iterator[Message]:
    """The messages for what the code calls at a port, without what only returns something or takes a function.

    Args:
        port: a device, or a channel for messages that have no class.
        seen: what was observed.
    """
    methods = {
        operation.name: operation.location
        for operation in port.operations
        if operation.is_method
        and operation.result is None
        and not (operation.is_registration or operation.name.startswith("__"))
    }
    methods |= {f"set_{operation.name}": operation.location for operation in port.operations
                if operation.is_set and not operation.is_registration}  # fmt: skip
    if len(methods) > 1 and {*methods} <= LOGS:
        return
    if port.role == "connection":
        methods = {name: calls[0].module.location(calls[0].node) for name in SENDS
                   for calls in [flow.calls.get(name)] if calls}  # fmt: skip
    if port.role in CHANNELS:
        methods = {"publish" if port.role == "bus" else "put": port.location}
    made: dict[str, Message] = {}
    for method, location in methods.items():
        sites = _sites(port, method, entry, seen)
        topics = {key: site for key, site in sites.items() if key}
        for topic, site in (topics or sites or {"": Site()}).items():
            named = port.name if port.role in CHANNELS else f"{port.name.strip('_')} {method.strip('_')}"
            title = camel(word(last_part(topic)) if topic else word(named))
            channel = f"{port.name}.{method} {topic}".rstrip()
            made.setdefault(title, _message(title, channel, site, location))
    yield from list(made.values())[:MAX_TOLD]


def messages_for_answers(inputs: Iterable[Message], seen: Observations) -> Iterator[Message]:
    """The messages for what calls of the code returned."""
    for message in {message.channel: message for message in inputs if message.form == "call"}.values():
        site = seen.calls.get(f"{ANSWER}.{message.channel}")
        if site is not None:
            title = camel(word(f"{message.channel.strip('_')} answer"))
            yield _message(title, f"{ANSWER}.{message.channel}", site, message.location)


def _message(title: str, channel: str, site: Site, location: CodeLine) -> Message:
    parts = tuple(_fields(site, location))
    return Message(title, snake(title), OWN_MODULE, "published", parts, location, (location,), "called", channel)


def with_methods(port: Port, entry: Entry, seen: Observations) -> Port:
    """A device with the methods that were observed, and that the source does not show, as of `getattr`."""
    there = {operation.name for operation in port.operations}
    names = [name for name in dict.fromkeys(_find_methods(port, entry, seen)) if name not in there]
    called = {key for key, site in seen.calls.items() if site.count}
    more = tuple(Operation(name, any(f"{owner}.{name}" in called for owner in _owners(port, entry)), port.location)
                 for name in names)  # fmt: skip
    return replace(port, operations=(*port.operations, *more)) if port.role == "device" else port


def _owners(port: Port, entry: Entry) -> tuple[str, ...]:
    """Names of a port where it was observed: of the tracer, and of stand-ins."""
    return f"{entry.name}.{port.name}", f"{entry.name}.__init__.{port.name}", port.name


def _find_methods(port: Port, entry: Entry, seen: Observations) -> Iterator[str]:
    """Methods that were called without taking a function."""
    for owner in _owners(port, entry):
        for key, site in seen.calls.items():
            name = key.removeprefix(f"{owner}.")
            is_told = not any(shape.kinds.get("callable") for shape in site.arguments.values())
            if key != name and name.isidentifier() and not name.startswith("_") and is_told:
                yield name


def _sites(port: Port, method: str, entry: Entry, seen: Observations) -> dict[str, Site]:
    """The observed calls of a method, by topic."""
    for owner in _owners(port, entry):
        head = f"{owner}.{method}"
        found = {key[len(head) :].strip(): site for key, site in seen.calls.items()
                 if key == head or key.startswith(f"{head} ")}  # fmt: skip
        if found:
            return found
    return {}


def _fields(site: Site, location: CodeLine) -> Iterator[MessageField]:
    """A field for each value of which the kind is known."""
    done: set[str] = set()
    flat: dict[str, Shape] = {}
    for name, shape in site.arguments.items():
        flat |= shape.fields if shape.fields else {name: shape}
    for key, shape in flat.items():
        name = f"value_{int(key) + 1}" if key.isdigit() else key
        kind, unique = kind_of_shape(shape), word(name)
        while unique in done:
            unique += "_"
        done.add(unique)
        if kind:
            unit = unit_of(name) if kind == "float" else ""
            yield MessageField(unique, kind, kind, location, texts_of_shape(shape, location), unit, is_partial=True)


def texts_of_shape(shape: Shape, location: CodeLine) -> tuple[FieldValue, ...]:
    """The texts that were observed of a value, where these are few."""
    texts = shape.texts if not shape.is_open else ()
    return tuple(FieldValue(text, location, is_observed=True) for text in texts if text not in ("", MASK))


def kind_of_shape(shape: Shape) -> str:
    """The kind of a field that has these values; empty if it has several."""
    kinds = set(shape.kinds) - {"none"}
    if kinds == {"bool"}:
        return "bool"
    if kinds and kinds <= {"int", "float"}:
        return "float"
    return "str" if kinds and kinds <= {"text", "enum"} else ""


MAX_SENSES = 12
"""Values of one class or module that a person sets."""

MAX_ARGUMENTS = 4
"""Most arguments of a call that have sensors of their own. More, such as the angles of a scanner, share one sensor."""


def absent_ports(seen: Observations, root: Path) -> Iterator[Port]:
    """A device for each class and module that the code uses; what it tests or compares is a sensor.

    Args:
        seen: observations in first runs.
        root: folder of the code.
    """
    registered = {key.removeprefix(CALLBACK).partition(" ")[0] for key in seen.methods if key.startswith(CALLBACK)}
    for name, place in seen.absent.items():
        # A key with a topic is that of a method, too.
        calls = {key: site for key, site in seen.calls.items() if key.startswith(f"{name}.") and " " not in key}
        calls = _with_arguments(calls)
        operations = [_operation(key.partition(".")[2], calls[key], root, key in registered) for key in sorted(calls)]
        sensed = [operation for operation in operations if operation.result is not None][:MAX_SENSES]
        called = [operation for operation in operations if operation.result is None and operation.is_method]
        results = {without_arguments(operation.name).removesuffix("()") for operation in sensed}
        others = [operation for operation in called if operation.name not in results]
        yield Port(name, "device", "", "", (*sensed, *others), _line(place, root))


def _with_arguments(calls: Mapping[str, Site]) -> dict[str, Site]:
    """The sites, those of one call with a single argument or with many as one."""
    keys: dict[str, list[str]] = {}
    for key in calls:
        keys.setdefault(without_arguments(key), []).append(key)
    made: dict[str, Site] = {}
    for general, specific in keys.items():
        for key in specific:
            site = made.setdefault(key if 1 < len(specific) <= MAX_ARGUMENTS else general, Site())
            site.merge(calls[key])
    return made


def _operation(name: str, site: Site, root: Path, is_registration: bool) -> Operation:
    """What the code called, or the value that it tested or compared."""
    location = _line(site.location, root)
    kind = "float" if site.compared else kind_of_shape(site.result)
    values = texts_of_shape(site.result, location) if kind == "str" else ()
    part = MessageField("value", "", kind, location, values, compared=tuple(sorted(site.compared)))
    is_sensed = kind in ("bool", "float") or bool(values)
    return Operation(name, bool(site.count), location, is_registration=is_registration,
                     result=part if is_sensed and not site.count else None)  # fmt: skip


def _line(place: str, root: Path) -> CodeLine:
    file, _, line = place.rpartition(":")
    path = Path(file).resolve()
    return CodeLine(path.relative_to(root).as_posix() if path.is_relative_to(root) else path.name, int(line or 0))
