"""Stand-ins for modules that are not installed, as the libraries of a robot's hardware on a developer's machine.

All that the code does with them crosses its border: they record what it calls, passes, tests and compares, and
return what a person sets. A *path* names it, as `Motor.sensor(2).distance()`: the class, or else the module, that the
code has imported, what it reads of it, and what it calls, with the only argument if that is a whole number or a name.
Outside of a run they are neutral.
"""

from __future__ import annotations

import re
import sys
from abc import ABCMeta
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from opcode import opname
from types import FrameType, ModuleType
from typing import Any

from pytest_hricdv.extra.draft.stand_ins.border import RunBorder
from pytest_hricdv.extra.draft.stand_ins.neutral import Neutral, UnknownValue
from pytest_hricdv.runtime.source_location import place_of

MAX_NAME = 30
"""Characters of a text that is a name of something; longer ones are content."""

_borders: list[RunBorder] = []
"""The border of the run under way; modules are imported once for all of them."""


@contextmanager
def cross_border(border: RunBorder) -> Iterator[None]:
    """Let what the code does with modules that are not installed cross the border of a run."""
    _borders.append(border)
    try:
        yield
    finally:
        _borders.remove(border)


class AbsentPart(UnknownValue):
    """An attribute, a method, or the result of a call, of something that is not installed; or a number set for it."""

    def __new__(cls, path: str, number: float = 0.0) -> AbsentPart:
        return float.__new__(cls, number)

    def __init__(self, path: str, number: float = 0.0) -> None:
        # The border makes it an object that the code shares with people.
        self.__dict__.update(_path=path, _border=_borders[-1] if _borders else None)

    def __getattr__(self, name: str) -> Any:
        path = self.__dict__["_path"]
        return _exception(path, name) if _is_caught(sys._getframe(1)) else _read(path, name)

    def __setattr__(self, name: str, value: Any) -> None:
        self.__dict__[name] = value
        _set(self.__dict__["_path"], name, value)

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
        """The code calls it; of a decorator, the function is kept as a callback."""
        if len(arguments) == 1 and not named and _is_function(arguments[0]):
            _call(self.__dict__["_path"], arguments, named)
            return arguments[0]
        return _call(self.__dict__["_path"], arguments, named)

    def _is_stream(self) -> bool:
        return self.__dict__["_path"].count("()") > 1 and bool(_borders)

    def __mro_entries__(self, _: tuple[object, ...]) -> tuple[type, ...]:
        return (_absent_class("Base"),)

    def _note_use(self, other: object) -> None:
        if _borders:
            _borders[-1].note_absent_use(self.__dict__["_path"], other, place_of(sys._getframe(2)))


def unknown(path: str) -> Any:
    """An argument of which nothing is known: what the code tests or compares of it is observed, and set by a person.

    Args:
        path: the function and its parameter, as "on_person.detection"; one object in each run.
    """
    if not _borders:
        return AbsentPart(path)
    return _borders[-1].unknown.setdefault(path, AbsentPart(path))


@dataclass(frozen=True)
class ProgramPort:
    """Another program that the code starts, but no run does: its arguments and results cross the border.

    Args:
        path: of the function that starts it, as "subprocess.run".
    """

    path: str

    def make(self, border: RunBorder, name: str) -> AbsentPart:
        """The function of a run."""
        return AbsentPart(self.path)


class _AbsentType(ABCMeta):
    """A class that is not installed: it has each attribute, and the code can derive from it, also with an ABC."""

    def __getattr__(cls, name: str) -> Any:
        return _part_of_module(cls.__name__, name)

    def __call__(cls, *arguments: Any, **named: Any) -> Any:
        made = super().__call__(*arguments, **named)
        if "_is_absent" in vars(cls):
            _call(cls.__name__, arguments, named)
        return made


class AbsentObject(Neutral):
    """An object of a class that is not installed, or of one that the code derives from it."""

    def __getattr__(self, name: str) -> Any:
        kind = next(base for base in type(self).__mro__ if "_is_absent" in vars(base))
        return _read(kind.__name__, name)

    def __setattr__(self, name: str, value: Any) -> None:
        self.__dict__[name] = value
        if "_is_absent" in vars(type(self)):
            _set(type(self).__name__, name, value)

    def __bool__(self) -> bool:
        return True  # there is such an object


def _absent_class(name: str) -> type:
    return _AbsentType(name, (AbsentObject,), {"_is_absent": True})


def _exception(owner: str, name: str) -> type[Exception]:
    return type(name, (Exception,), {"__module__": owner})


def _is_caught(frame: FrameType) -> bool:
    """Whether an `except` reads an attribute, maybe through a stand-in of its module."""
    while frame.f_code.co_name == "__getattr__" and frame.f_back is not None:
        frame = frame.f_back
    following = (operation for operation in frame.f_code.co_code[frame.f_lasti + 2 :: 2] if operation)
    return opname[next(following, 0)] == "CHECK_EXC_MATCH"


def _part_of_module(owner: str, name: str) -> Any:
    """What a module or class has of this name: by PEP 8, an exception, a class, or a function or value."""
    if name.startswith("__"):
        raise AttributeError(name)
    if name.endswith(("Error", "Exception")):
        return _exception(owner, name)
    return _absent_class(name) if name[:1].isupper() and not name.isupper() else AbsentPart(f"{owner}.{name}")


def _read(path: str, name: str) -> Any:
    """The code reads an attribute: what a person has set, or something of which nothing is known."""
    if name.startswith("__"):
        raise AttributeError(name)
    part = f"{path}.{name}"
    if not _borders:
        return AbsentPart(part)
    border = _borders[-1]
    border.pass_time()
    return _part(part)


def _part(path: str) -> Any:
    """What a person has set, or something of which nothing is known."""
    sense = _sense(_borders[-1], path) if _borders else ""
    return _value_of(_borders[-1], sense, path) if sense else AbsentPart(path)


def _sense(border: RunBorder, path: str) -> str:
    """The sensor at a path, or the one for all arguments; empty if there is none."""
    return next((name for name in (path, without_arguments(path)) if name in border.senses), "")


def without_arguments(path: str) -> str:
    """The path of a call with any argument.

    >>> without_arguments("Motor.sensor(2).distance()")
    'Motor.sensor().distance()'
    """
    return re.sub(r"\(\w+\)", "()", path)


def _argument_text(arguments: tuple[Any, ...], named: dict[str, Any]) -> str:
    """The text of the only argument, which may tell which one is meant: a pin, a channel, a name; otherwise empty."""
    value = arguments[0] if len(arguments) == 1 and not named else None
    if isinstance(value, AbsentPart):  # a constant that is not installed
        value = value.__dict__["_path"].rpartition(".")[2]
    is_name = isinstance(value, str) and value.isidentifier() and len(value) <= MAX_NAME
    return str(value) if is_name or (type(value) is int and value >= 0) else ""


def _set(path: str, name: str, value: Any) -> None:
    """The code sets an attribute."""
    if _borders and _is_function(value):
        _borders[-1].register(f"{path}.{name}", value)
    elif _borders:
        _call(f"{path}.set_{name}", (value,), {})


def _call(path: str, arguments: tuple[Any, ...], named: dict[str, Any]) -> Any:
    """The code calls something: returns what a person has set, or something of which nothing is known."""
    if not _borders:
        return AbsentPart(f"{path}()")
    made = f"{path}({_argument_text(arguments, named)})"
    border, (port, _, name) = _borders[-1], without_arguments(path).partition(".")
    border.note_absent_call(port, name or "__call__", arguments, named, place_of(sys._getframe(2)))
    if sense := _sense(border, made):
        return _value_of(border, sense, made)
    if not any(map(_is_function, (*arguments, *named.values()))):
        border.tell_call(port, name or "__call__", arguments, named)
    return AbsentPart(made)


def _value_of(border: RunBorder, sense: str, path: str) -> Any:
    """The value of a sensor, which the code reads at a path of its own where the sensor is for all arguments."""
    border.on_crossing()
    value = border.read_sense(sense)
    if isinstance(value, float):
        return AbsentPart(path, value)
    if path != sense:
        border.note_absent_use(path, value, place_of(sys._getframe(3)))
    return value


def _is_function(value: Any) -> bool:
    return callable(value) and not isinstance(value, type | Neutral)


class _AbsentModule(ModuleType):
    """A module that is not installed."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.__path__ = []  # so that it has submodules

    def __getattr__(self, name: str) -> Any:
        # It is kept: `except` needs the class that was raised.
        make = _exception if _is_caught(sys._getframe(1)) else _part_of_module
        self.__dict__[name] = found = make(self.__name__.rpartition(".")[2], name)
        return found


class _AbsentFinder(MetaPathFinder, Loader):
    """Finds the modules that are not installed."""

    def __init__(self, names: frozenset[str]) -> None:
        self.names = names

    def find_spec(self, fullname: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        """Find these modules, and those in them."""
        is_absent = any(f"{fullname}.".startswith(f"{name}.") for name in self.names)
        return ModuleSpec(fullname, self, is_package=True) if is_absent else None

    def create_module(self, spec: ModuleSpec) -> _AbsentModule:
        """A stand-in."""
        return _AbsentModule(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        """There is nothing to execute."""


def replace_modules(*names: str) -> None:
    """Let code be imported without modules that are not installed: each gets a stand-in."""
    if not any(isinstance(finder, _AbsentFinder) and finder.names == {*names} for finder in sys.meta_path):
        sys.meta_path.insert(0, _AbsentFinder(frozenset(names)))
