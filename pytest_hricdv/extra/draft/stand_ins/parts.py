"""Stand-ins for what the code uses: devices, other programs, and everything in modules that are not installed.

They record what the code calls, passes, tests and compares, and return what a person sets; outside of a run they are
neutral. A draft declares a `Device`, or `unknown` for an argument; each part of it is an `OutsidePart` with a *path*,
such as `Motor.sensor(2).distance()`: the port, class or module, the attributes read and the methods called. In modules
that are not installed, a call has its only argument in the path if this is an integer or a name.
"""

from __future__ import annotations

import asyncio
import re
import sys
from abc import ABCMeta
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from opcode import opname
from types import FrameType
from typing import Any

from pytest_hricdv.extra.draft.stand_ins.border import RunBorder, first_text
from pytest_hricdv.extra.draft.stand_ins.channels import AsyncInbox, Convert, Inbox
from pytest_hricdv.extra.draft.stand_ins.neutral import REST_OF_RUN_S, Neutral
from pytest_hricdv.runtime.source_location import place_of

MAX_NAME = 30
"""Most characters of a text that is a name of something; longer ones are content."""

_borders: list[RunBorder] = []
"""The border of the run under way; modules are imported once for all of them."""


@contextmanager
def cross_border(border: RunBorder) -> Iterator[None]:
    """Let what the code does with stand-ins cross the border of a run."""
    _borders.append(border)
    try:
        yield
    finally:
        _borders.remove(border)


class OutsidePart(Neutral):
    """An attribute, a method, or the result of a call, of something outside; or a number set for it.

    It notes how the code uses it: as a condition, or in a comparison with a text or number. As a decorator, it
    keeps the function as a callback.
    """

    def __new__(cls, path: str, number: float = 0.0, text: str = "") -> OutsidePart:
        return float.__new__(cls, number)

    def __init__(self, path: str, number: float = 0.0, text: str = "") -> None:
        # The border makes it an object that the code shares with people.
        self.__dict__.update(_path=path, _text=text, _border=_borders[-1] if _borders else None)

    def __getattr__(self, name: str) -> Any:
        path = self.__dict__["_path"]
        return exception_type(path, name) if is_caught(sys._getframe(1)) else read(path, name)

    def __setattr__(self, name: str, value: Any) -> None:
        self.__dict__[name] = value
        set_attribute(self.__dict__["_path"], name, value)

    def __getitem__(self, key: Any) -> Any:
        """A value of a dict has its key in its path; the elements of a list have one path."""
        path = self.__dict__["_path"]
        return _part(f"{path}[{key}]" if isinstance(key, str) and key.isidentifier() else path)

    def __iter__(self) -> Iterator[Any]:
        """As many parts as it is unpacked into, as by `x, y = arm.position()`; otherwise none."""
        frame = sys._getframe(1)
        operation, count = frame.f_code.co_code[frame.f_lasti : frame.f_lasti + 2]
        count = count if opname[operation] in ("UNPACK_SEQUENCE", "UNPACK_EX") else 0
        return iter([_part(f"{self.__dict__['_path']}[{number}]") for number in range(count)])

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """The code calls it."""
        path = self.__dict__["_path"]
        if len(arguments) != 1 or named or not _is_function(arguments[0]):
            return call(path, arguments, named)
        if not path.endswith(")"):
            call(path, arguments, named)
        elif _borders:
            _borders[-1].register(path[: path.rindex("(")], arguments[0], self.__dict__["_text"])
        return arguments[0]

    def __mro_entries__(self, _: tuple[object, ...]) -> tuple[type, ...]:
        return (_absent_class("Base"),)

    def _note_use(self, other: object) -> None:
        if _borders:
            _note_use(_borders[-1], self.__dict__["_path"], other)

    def __await__(self) -> Generator[Any, Any, Any]:
        """A coroutine that waits for something of an answer, as for the next message of a connection, waits for the
        rest of the run: nobody knows what comes."""
        is_stream = self.__dict__["_path"].count("(") > 1 and bool(_borders)
        yield from asyncio.sleep(REST_OF_RUN_S if is_stream else 0).__await__()
        return self

    async def __anext__(self) -> Any:
        await asyncio.sleep(REST_OF_RUN_S)
        raise StopAsyncIteration

    def __bool__(self) -> bool:
        self._note_use(False)
        return float(self) != 0.0

    def __eq__(self, other: object) -> bool:
        self._note_use(other)
        return float(self) == other

    def __ne__(self, other: object) -> bool:
        return not self == other

    __hash__ = float.__hash__

    def __lt__(self, other: float) -> bool:
        self._note_use(other)
        return float.__lt__(self, other)

    def __gt__(self, other: float) -> bool:
        self._note_use(other)
        return float.__gt__(self, other)

    def __le__(self, other: float) -> bool:
        self._note_use(other)
        return float.__le__(self, other)

    def __ge__(self, other: float) -> bool:
        self._note_use(other)
        return float.__ge__(self, other)


class DeviceStandIn(OutsidePart):
    """A fake of a device: it is there, whatever is known of it."""

    def __new__(cls, *_: Any) -> DeviceStandIn:
        return float.__new__(cls)

    def __bool__(self) -> bool:
        return True


@dataclass(frozen=True)
class Device:
    """A port that is a device, or whatever else the code uses.

    Methods have parentheses in the names of these arguments, as "position()"; attributes have none.

    Args:
        senses: what a person sets.
        answers: -> a function that makes the value; what is neither here nor set by a person is something of which
            nothing is known: 0, empty, and can be awaited and called.
        coroutines: names of methods that are awaited.
        inboxes: methods that return what people say, and attributes that are lists of it -> class of a message ->
            conversion.
    """

    senses: tuple[str, ...] = ()
    answers: Mapping[str, Callable[[], Any]] = field(default_factory=dict)
    coroutines: tuple[str, ...] = ()
    inboxes: Mapping[str, Mapping[type[Any], Convert]] = field(default_factory=dict)

    def make(self, border: RunBorder, name: str) -> Any:
        """The stand-in of a run."""
        kind: Any = AsyncInbox if border.is_async else Inbox
        border.devices.add(name)
        border.answers |= {_join(name, path): make for path, make in self.answers.items()}
        border.inboxes |= {_join(name, path): kind(border, kinds) for path, kinds in self.inboxes.items()}
        border.coroutines |= {f"{name}.{method}" for method in self.coroutines}
        return DeviceStandIn(name)


def _join(port: str, path: str) -> str:
    return f"{port}{path}" if path.startswith("(") else f"{port}.{path}"


def unknown(path: str) -> Any:
    """An argument of which nothing is known: what the code tests or compares of it is observed, and set by a person.

    Args:
        path: the function and its parameter, as "on_person.detection"; one object in each run.
    """
    if not _borders:
        return OutsidePart(path)
    return _borders[-1].unknown.setdefault(path, OutsidePart(path))


# --- what crosses the border


def read(path: str, name: str) -> Any:
    """The code reads an attribute: what a person has set, or something of which nothing is known."""
    if name.startswith("__"):
        raise AttributeError(name)
    if _borders:
        _borders[-1].pass_time()
    return _part(f"{path}.{name}")


def set_attribute(path: str, name: str, value: Any) -> None:
    """The code sets an attribute."""
    if _borders and _is_function(value):
        _borders[-1].register(f"{path}.{name}", value)
    elif _borders:
        call(f"{path}.set_{name}", (value,), {})


def call(path: str, arguments: tuple[Any, ...], named: dict[str, Any]) -> Any:
    """The code calls something: returns what a person has set, or something of which nothing is known."""
    if not _borders:
        return OutsidePart(f"{path}()")
    border, (port, _, name) = _borders[-1], without_arguments(path).partition(".")
    is_device = port in border.devices
    border.note_call(port, name or "__call__", arguments, named, "" if is_device else place_of(sys._getframe(2)))
    made = f"{path}({'' if is_device else _argument_text(arguments, named)})"
    if path in border.coroutines:
        inbox = border.inboxes.get(made)
        return inbox.get() if inbox is not None else _later(_part(made))
    is_known = bool(_sense(border, made)) or made in border.inboxes
    if not is_known and not any(map(_is_function, (*arguments, *named.values()))):
        border.tell_call(port, name or "__call__", arguments, named)
    return _part(made, first_text(arguments))


async def _later(value: Any) -> Any:
    await asyncio.sleep(0)
    return value


def _part(path: str, text: str = "") -> Any:
    """What people say or have set, or a device answers; or something of which nothing is known."""
    if not _borders:
        return OutsidePart(path)
    border = _borders[-1]
    inbox = border.inboxes.get(path)
    if inbox is not None:
        border.on_crossing()
        if not path.endswith(")"):
            return list(iter(inbox.poll, None))  # all that has come since
        if (message := inbox.poll()) is not None:
            return message
    if sense := _sense(border, path):
        return _value_of(border, sense, path)
    return border.answers[path]() if path in border.answers else OutsidePart(path, 0.0, text)


def _sense(border: RunBorder, path: str) -> str:
    """The sensor at a path, or the one for all arguments; empty if there is none."""
    return next((name for name in (path, without_arguments(path)) if name in border.senses), "")


def _value_of(border: RunBorder, sense: str, path: str) -> Any:
    """The value of a sensor, which the code reads at a path of its own where the sensor is for all arguments."""
    border.on_crossing()
    value = border.read_sense(sense)
    has_parts = any(other.startswith(f"{sense}.") for other in border.senses)
    if isinstance(value, float) or (isinstance(value, bool) and has_parts):
        return OutsidePart(path, float(value))
    if path != sense:
        _note_use(border, path, value)
    return value


def _note_use(border: RunBorder, path: str, other: object) -> None:
    is_device = path.partition(".")[0].partition("(")[0] in border.devices
    border.note_use(path, other, "" if is_device else place_of(sys._getframe(2)))


def without_arguments(path: str) -> str:
    """The path of a call with any argument.

    >>> without_arguments("Motor.sensor(2).distance()")
    'Motor.sensor().distance()'
    """
    return re.sub(r"\(\w+\)", "()", path)


def _argument_text(arguments: tuple[Any, ...], named: dict[str, Any]) -> str:
    """The text of the only argument, which may tell which one is meant: a pin, a channel, a name; otherwise empty."""
    value = arguments[0] if len(arguments) == 1 and not named else None
    if isinstance(value, OutsidePart):  # a constant that is not installed
        value = value.__dict__["_path"].rpartition(".")[2]
    is_name = isinstance(value, str) and value.isidentifier() and len(value) <= MAX_NAME
    return str(value) if is_name or (type(value) is int and value >= 0) else ""


def _is_function(value: Any) -> bool:
    return callable(value) and not isinstance(value, type | Neutral)


# --- classes that are not installed


class _AbsentType(ABCMeta):
    """A class that is not installed: it has each attribute, and the code can derive from it, also with an ABC."""

    def __getattr__(cls, name: str) -> Any:
        return part_of_module(cls.__name__, name)

    def __call__(cls, *arguments: Any, **named: Any) -> Any:
        made = super().__call__(*arguments, **named)
        if "_is_absent" in vars(cls):
            call(cls.__name__, arguments, named)
        return made


class AbsentObject(Neutral):
    """An object of a class that is not installed, or of one that the code derives from it."""

    def __getattr__(self, name: str) -> Any:
        kind = next(base for base in type(self).__mro__ if "_is_absent" in vars(base))
        return read(kind.__name__, name)

    def __setattr__(self, name: str, value: Any) -> None:
        self.__dict__[name] = value
        if "_is_absent" in vars(type(self)):
            set_attribute(type(self).__name__, name, value)

    def __bool__(self) -> bool:
        return True  # there is such an object


def _absent_class(name: str) -> type:
    return _AbsentType(name, (AbsentObject,), {"_is_absent": True})


def exception_type(owner: str, name: str) -> type[Exception]:
    """An exception that is not installed."""
    return type(name, (Exception,), {"__module__": owner})


def is_caught(frame: FrameType) -> bool:
    """Whether an `except` reads an attribute, maybe through a stand-in of its module."""
    while frame.f_code.co_name == "__getattr__" and frame.f_back is not None:
        frame = frame.f_back
    following = (operation for operation in frame.f_code.co_code[frame.f_lasti + 2 :: 2] if operation)
    return opname[next(following, 0)] == "CHECK_EXC_MATCH"


def part_of_module(owner: str, name: str) -> Any:
    """What a module or class has of this name: by PEP 8, an exception, a class, or a function or value."""
    if name.startswith("__") or name == "_fields":  # else objects of a class were named tuples
        raise AttributeError(name)
    if name.endswith(("Error", "Exception")):
        return exception_type(owner, name)
    return _absent_class(name) if name[:1].isupper() and not name.isupper() else OutsidePart(f"{owner}.{name}")
