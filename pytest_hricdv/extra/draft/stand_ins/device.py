"""Stand-ins of devices: record the code's calls, and return what a person of the model sets, or a neutral value."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from pytest_hricdv.extra.draft.stand_ins.border import RunBorder, first_text
from pytest_hricdv.extra.draft.stand_ins.channels import AsyncInbox, Convert, Inbox
from pytest_hricdv.extra.draft.stand_ins.neutral import Neutral, NeutralNumber, UnknownValue


@dataclass(frozen=True)
class Device:
    """A port that is a device, or whatever else the code uses.

    Args:
        senses: methods and attributes whose value a person sets.
        answers: method or attribute -> a function that makes what it returns; what is in neither returns a neutral
            value of no type, which is 0, empty, and can be awaited and called.
        attributes: those of them that are no methods.
        coroutines: methods that are awaited.
        inboxes: method or attribute, of a list -> what it returns of what people say: class of a message -> conversion.
    """

    senses: tuple[str, ...] = ()
    answers: Mapping[str, Callable[[], Any]] = field(default_factory=dict)
    attributes: tuple[str, ...] = ()
    coroutines: tuple[str, ...] = ()
    inboxes: Mapping[str, Mapping[type[Any], Convert]] = field(default_factory=dict)

    def make(self, border: RunBorder, name: str) -> Any:
        """The stand-in of a run."""
        return DeviceStandIn(border, name, self)


class DeviceStandIn(Neutral):
    """A fake of a device."""

    def __init__(self, border: RunBorder, name: str, device: Device) -> None:
        kind: Any = AsyncInbox if border.is_async else Inbox
        inboxes = {method: kind(border, kinds) for method, kinds in device.inboxes.items()}
        self.__dict__.update(_border=border, _name=name, _device=device, _inboxes=inboxes)

    def __bool__(self) -> bool:
        return True  # there is a device

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        device: Device = self.__dict__["_device"]
        if name in device.attributes:
            return self._value(name, read=True)
        self.__dict__["_border"].pass_time()
        return _Method(self, name)

    def __setattr__(self, name: str, value: Any) -> None:
        self.__dict__[name] = value
        border, port = self.__dict__["_border"], self.__dict__["_name"]
        if callable(value):
            border.register(f"{port}.{name}", value)
        else:
            border.note_call(port, f"set_{name}", (value,), {})
            border.tell_call(port, f"set_{name}", (value,), {})

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """The device itself is a function."""
        return self._cross("__call__", arguments, named)

    def _cross(self, name: str, arguments: tuple[Any, ...], named: Mapping[str, Any]) -> Any:
        """The code calls a method."""
        border, port, device = self.__dict__["_border"], self.__dict__["_name"], self.__dict__["_device"]
        border.note_call(port, name, arguments, named)
        inbox = self.__dict__["_inboxes"].get(name)
        if inbox is not None and name in device.coroutines:
            return inbox.get()
        message = inbox.poll() if inbox is not None else None
        if message is not None:
            return message
        is_registration = any(callable(argument) and not isinstance(argument, type | Neutral) for argument in arguments)
        if name not in device.senses and inbox is None and not is_registration:
            border.tell_call(port, name, arguments, named)
        value = self._value(name, read=False, text=first_text(arguments))
        return _later(value) if name in device.coroutines else value

    def _value(self, name: str, *, read: bool, text: str = "") -> Any:
        border, port, device = self.__dict__["_border"], self.__dict__["_name"], self.__dict__["_device"]
        if read:
            border.pass_time()
            border.on_crossing()
        if read and name in self.__dict__["_inboxes"]:
            return list(iter(self.__dict__["_inboxes"][name].poll, None))  # all that has come since
        if name in device.senses:
            value = _value_of_sense(border, f"{port}.{name}")
        else:
            make = device.answers.get(name)
            value = make() if make is not None else _Answer(border, f"{port}.{name}", text)
        border.answer(port, name, value)
        return value


def _value_of_sense(border: RunBorder, name: str) -> Any:
    """The value that a person has set; a truth with parts has them."""
    value = border.read_sense(name)
    if isinstance(value, bool) and any(other.startswith(f"{name}.") for other in border.senses):
        return _Answer(border, name, truth=value)
    return NeutralNumber(value) if isinstance(value, float) else value


class _Method(UnknownValue):
    """A method of a device, or an attribute of which nothing is known."""

    def __init__(self, owner: DeviceStandIn, name: str) -> None:
        self.__dict__.update(_owner=owner, _method=name)

    def _note_use(self, other: object) -> None:
        owner = self.__dict__["_owner"].__dict__
        owner["_border"].note_use(f"{owner['_name']}.{self.__dict__['_method']}", other, is_attribute=True)

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """The code calls it."""
        return self.__dict__["_owner"]._cross(self.__dict__["_method"], arguments, named)


class _Answer(UnknownValue):
    """The result of an unknown method; as a decorator, it keeps the function as a callback.

    A coroutine that waits for something of it, as for the next message of a subscription, waits for the rest of the
    run: nobody knows what comes.
    """

    def __init__(self, border: RunBorder, name: str, text: str = "", truth: bool = False) -> None:
        self.__dict__.update(_border=border, _called=name, _text=text, _truth=truth)

    def __bool__(self) -> bool:
        self._note_use(False)
        return bool(self.__dict__["_truth"])

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        border, part = self.__dict__["_border"], f"{self.__dict__['_called']}.{name}"
        return _value_of_sense(border, part) if part in border.senses else _Answer(border, part)

    def _note_use(self, other: object) -> None:
        if self.__dict__["_called"].count(".") == 1:  # and not of a part of it
            self.__dict__["_border"].note_use(self.__dict__["_called"], other)

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Neutral; of a decorator, the function."""
        border, called = self.__dict__["_border"], self.__dict__["_called"]
        if len(arguments) == 1 and not named and callable(arguments[0]):
            border.register(called, arguments[0], self.__dict__["_text"])
            return arguments[0]
        port, _, method = called.partition(".")
        border.note_call(port, method, arguments, named)
        return _Answer(border, called)

    def _is_stream(self) -> bool:
        return str(self.__dict__["_called"]).count(".") > 1


async def _later(value: Any) -> Any:
    await asyncio.sleep(0)
    return value
