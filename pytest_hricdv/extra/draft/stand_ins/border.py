"""`RunBorder`: what passes between the code and its stand-ins in one run, recorded and told to the test's bus.

A call of a stand-in becomes a message, from its content (`ToldContent`): a topic, names and values in its arguments.
"""

from __future__ import annotations

import inspect
import json
import os
import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from enum import Enum
from pathlib import Path
from typing import Any

from pytest_hricdv.extra.draft.code.naming import word
from pytest_hricdv.extra.draft.observe.observations import Observations, read_observations, write_atomically
from pytest_hricdv.extra.draft.observe.tracer import CALLBACK, texts_of
from pytest_hricdv.extra.draft.stand_ins.neutral import Neutral
from pytest_hricdv.run import Run
from pytest_hricdv.runtime import text_of


@dataclass
class ToldContent:
    """The arguments of a call, as the fields of a message.

    Args:
        topic: the text before a dict, JSON or tuple; empty if there is none.
        named: values by the names that they have in it.
        others: all other values, in their order.
    """

    topic: str = ""
    named: dict[str, Any] = field(default_factory=dict)
    others: list[Any] = field(default_factory=list)

    @property
    def arguments(self) -> dict[str, Any]:
        """All values; positional ones are named by their numbers."""
        return {**{str(number): value for number, value in enumerate(self.others)}, **self.named}

    def message(self, kind: type[Any]) -> Any:
        """The content as a message of a class, whose fields without a value are neutral."""
        left = list(self.others)
        values = {}
        for part in fields(kind):
            has_value = part.name in self.named or bool(left)
            value = self.named[part.name] if part.name in self.named else left.pop(0) if left else None
            values[part.name] = _as(part.type, value) if has_value else _as(part.type, None)
        return kind(**values)


def read_content(arguments: Sequence[Any], named: Mapping[str, Any], is_broker: bool = False) -> ToldContent:
    """The content of a call; a broker is called with a topic first.

    >>> read_content(("ward/state", '{"state": "up", "height_cm": 60}'), {"qos": 1})
    ToldContent(topic='ward/state', named={'state': 'up', 'height_cm': 60}, others=[])
    >>> read_content(("mouth", 1), {})
    ToldContent(topic='', named={}, others=['mouth', 1])
    """
    told = ToldContent(named={word(name): value for name, value in named.items() if _is_plain(value)})
    every = list(arguments)
    if len(every) == 1 and type(every[0]) is tuple:
        every, is_topic = list(every[0]), True
    else:
        is_topic = len(every) > 1 and isinstance(every[0], str) and ("/" in every[0] or _members(every[1]) is not None)
    for number, value in enumerate(every):
        members = _members(value)
        if (is_topic or is_broker) and number == 0 and isinstance(value, str):
            told.topic = value
            told.named = {} if is_topic else told.named  # of a topic and a message: how it is published
        elif members is not None:
            told.named |= {word(name): part for name, part in members.items() if _is_plain(part)}
        elif _is_plain(value):
            told.others.append(value)
    return told


def _members(value: Any) -> Mapping[str, Any] | None:
    """The members of a dict, of JSON of one, or of a message; None of anything else."""
    if isinstance(value, bytes | bytearray | str) and value[:1] in ("{", b"{"):
        try:
            value = json.loads(value)
        except (ValueError, RecursionError):
            return None
    if isinstance(value, Mapping):
        return {str(name): part for name, part in value.items()}
    names = getattr(type(value), "__dataclass_fields__", None) or getattr(type(value), "_fields", None)
    return {name: getattr(value, name, None) for name in names} if names else None


def _is_plain(value: Any) -> bool:
    return value is None or (isinstance(value, bool | int | float | str | bytes | Enum)
                             and not isinstance(value, Neutral))  # fmt: skip


def _as(kind: Any, value: Any) -> Any:
    """A value as a field of this type has it."""
    if kind in (bool, "bool"):
        return bool(value)
    if kind in (float, "float", int, "int"):
        return float(value) if isinstance(value, int | float) else 0.0
    value = text_of(value) if isinstance(value, Enum) else value
    value = bytes(value).decode("utf-8", "replace") if isinstance(value, bytes | bytearray) else value
    return value.strip() if isinstance(value, str) else "" if value is None else str(value)


OBSERVE = "HRICDV_OBSERVE"
"""The environment variable with the file to which first runs add what they observe."""

ANSWER = "answer"
"""The port at which others see what a call of the code returns."""

REPEATS_S = 1.0
"""A call that comes again within this time is told once, as in a loop that sets a motor each 0.1 s."""


@dataclass
class RunBorder:
    """The state that the stand-ins of one run share.

    Args:
        run: the test's run.
        kinds: classes that the bus of the run carries.
        called: "port.method", or "port.method topic" -> class of the message that says that the code has called it.
        senses: what devices return next, by "port.name".
        takes_s: simulated time that each call of a device takes; a loop that only asks devices would not end.
        is_async: whether the code is a coroutine.
    """

    run: Run
    kinds: frozenset[type[Any]]
    called: Mapping[str, type[Any]]
    senses: dict[str, Any]
    takes_s: float = 0.0
    is_async: bool = False
    callbacks: dict[str, list[Callable[..., Any]]] = field(default_factory=lambda: defaultdict(list))
    """Callbacks that the code has passed to a port, by "port.method" or "port.method text"."""
    instance: Any = None
    """The object of the code, once it is made."""
    devices: set[str] = field(default_factory=set)
    """Ports that are devices of the code, and no modules that are not installed."""
    answers: dict[str, Callable[[], Any]] = field(default_factory=dict)
    """What devices return that nobody sets: path -> what makes it."""
    inboxes: dict[str, Any] = field(default_factory=dict)
    """Paths of devices at which what people say comes in."""
    coroutines: set[str] = field(default_factory=set)
    """Paths of methods that are awaited."""
    unknown: dict[str, Any] = field(default_factory=dict)
    """Arguments of which nothing is known, by function and parameter."""
    on_crossing: Callable[[], None] = lambda: None
    """Called when the code calls something outside, or was called."""
    on_said: Callable[[Any], None] = lambda _: None
    """Called with each message of the code."""
    _last_calls: dict[str, tuple[Any, float]] = field(default_factory=dict)
    _seen: Observations | None = field(default_factory=lambda: Observations() if OBSERVE in os.environ else None)
    _states: dict[str, str] = field(default_factory=dict)
    _set: set[str] = field(default_factory=set)

    def record(self, name: str, value: bool | float | str) -> None:
        """Record a signal."""
        self.run.recorder.signal(self.run.kernel.now_s, name, value)

    def sense(self, name: str, value: bool | float | str) -> None:
        """Let a device return a value from now on."""
        self.senses[name] = value
        self._set.add(name)
        self.record(signal_name(name), value)

    def read_sense(self, name: str) -> Any:
        """What a device returns; a value that a person has set reaches the code by it."""
        if name in self._set:
            self.run.bus.note_taking()
        return self.senses[name]

    def pass_time(self) -> None:
        """Let the time pass that each use of a device takes."""
        if self.takes_s and not self.is_async:
            self.run.kernel.sleep(self.takes_s)

    def note_call(
        self, port: str, name: str, arguments: tuple[Any, ...], named: Mapping[str, Any], place: str = ""
    ) -> None:
        """Note that the code has called a method of a port; functions among the arguments are its callbacks.

        `place` is where the code calls it; empty unless it is of a module that is not installed.
        """
        self.pass_time()
        self.on_crossing()
        every = (*arguments, *named.values())
        for value in every:
            if callable(value) and not isinstance(value, type):
                self.register(f"{port}.{name}", value, first_text(other for other in every if other is not value))
        if self._seen is None:
            return
        told = read_content(arguments, named, self._is_broker(port))
        for key in dict.fromkeys((f"{port}.{name}", f"{port}.{name} {told.topic}".rstrip())):
            site = self._seen.site(self._seen.calls, key)
            if site is not None:
                site.add(told.arguments, place)
        if place:
            self._seen.absent.setdefault(port, place)

    def note_use(self, path: str, other: Any, place: str = "") -> None:
        """Note that the code tests something of which nothing is known, or compares it; `place` as of `note_call`."""
        site = self._seen.site(self._seen.calls, path) if self._seen is not None else None
        if site is None or self._seen is None:
            return
        if place:
            site.location = site.location or place
            self._seen.absent.setdefault(path.partition(".")[0], place)
        if isinstance(other, Neutral):  # a constant that is not installed either: equal to it, or not
            if place:
                site.result.add(False)
        elif isinstance(other, bool | str):
            site.result.add(other)
        elif isinstance(other, int | float):
            site.note_comparison(float(other))

    def register(self, name: str, function: Callable[..., Any], text: str = "") -> None:
        """Keep a function that the code wants to be called."""
        self.callbacks[name].append(function)
        if text:
            self.callbacks[f"{name} {text}"].append(function)

    def _is_broker(self, port: str) -> bool:
        """Whether the code has registered functions with a port by a text: then the first text of a call is a topic."""
        return any(key.startswith(f"{port}.") and " " in key for key in self.callbacks)

    def tell_call(self, port: str, name: str, arguments: Sequence[Any], named: Mapping[str, Any]) -> None:
        """Tell others that the code has called a port: by the message of its topic, or of its method."""
        told = read_content(arguments, named, self._is_broker(port))
        called = next((key for key in (f"{port}.{name} {told.topic}", f"{port}.{name}") if key in self.called), None)
        if called is None:
            return
        message = told.message(self.called[called])
        before, now_s = self._last_calls.get(called), self.run.kernel.now_s
        self._last_calls[called] = (message, now_s)
        if before is None or before[0] != message or not 0.0 < now_s - before[1] <= REPEATS_S:
            self.run.bus.publish(port, message)

    def tell_answer(self, name: str, value: Any) -> None:
        """Tell what a call of the code returned: a text, or something with names in it."""
        told = read_content((value,), {})
        if told.named or isinstance(value, str | bytes):
            self.note_call(ANSWER, name, (value,), {})
            self.tell_call(ANSWER, name, (value,), {})

    def say(self, port: str, name: str, contents: tuple[Any, ...]) -> None:
        """Publish a call of the code: the message among its arguments, or the call itself."""
        for message in contents:
            if type(message) in self.kinds:
                self.run.bus.publish("robot", message)
                self.on_said(message)
                return
        self.tell_call(port, name, contents, {})

    def note_states(self) -> None:
        """Observe which texts the attributes of the object have."""
        if self._seen is None or self.instance is None:
            return
        kind = type(self.instance)
        for name, text in texts_of(self.instance).items():
            if self._states.get(name) != text:
                self._seen.add_state(f"{kind.__module__}:{kind.__qualname__}.{name}", self._states.get(name), text)
                self._states[name] = text

    def close(self) -> None:
        """Add what was observed to the file of first runs."""
        if self._seen is None:
            return
        for name, functions in self.callbacks.items():
            site = self._seen.site(self._seen.methods, f"{CALLBACK}{name}")
            if site is not None:
                site.add({}, _location(functions[-1]))
        path = Path(os.environ[OBSERVE])
        if path.exists():
            self._seen.merge(read_observations(path))
        write_atomically(path, self._seen.to_json())


def _location(function: Callable[..., Any]) -> str:
    """The location of a function's definition; empty if it is not in Python."""
    code = getattr(inspect.unwrap(getattr(function, "func", function)), "__code__", None)
    return f"{code.co_filename}:{code.co_firstlineno}" if code is not None else ""


def signal_name(name: str) -> str:
    """The signal of what a device returns.

    >>> signal_name("door.is_open"), signal_name("kocher.gießen"), signal_name("Arm.pose(2).x")
    ('door_is_open', 'kocher_gie_en', 'Arm_pose_2_x')
    """
    return re.sub(r"\W", "_", name.replace("()", "").replace(")", ""), flags=re.ASCII)


def first_text(values: Iterable[Any]) -> str:
    """The first text, or member of an enumeration, among values; empty if there is none."""
    texts = (text_of(value) if isinstance(value, Enum) else value for value in values)
    return next((text for text in texts if isinstance(text, str)), "")
