"""Generates the classes of messages, services and actions from interface files of packages that are not installed.

`class_of_file` makes the class for one file, parsed by `interface_text`; `interface_packages` calls it when code under
test imports the class. The classes are like those that `rosidl` generates: slots, defaults, checked setters,
`SLOT_TYPES`.
"""

from __future__ import annotations

import array
import copy
import importlib
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from pytest_hricdv._base.message import nearest
from pytest_hricdv.declarations.ros2 import Ros2Error
from pytest_hricdv.extra.ros2.interface_text import FieldType, InterfaceField, Part, parts_of

FOLDERS = ("msg", "srv", "action")

_ARRAY_CODES = {
    "float": "f",
    "double": "d",
    "int8": "b",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
}
"""Type of numbers -> the type code of `array.array`, which numpy understands, too."""

_KINDS: dict[str, type] = {
    "boolean": bool,
    "octet": bytes,
    "float": float,
    "double": float,
    "string": str,
    "wstring": str,
}
_MAX_FLOAT32 = 3.4028234663852886e38  # the largest float32


class _Interface(type):
    """The metaclass of messages, with the attributes that `rclpy` expects: a type support, which converts nothing."""

    _CREATE_ROS_MESSAGE = _CONVERT_FROM_PY = _CONVERT_TO_PY = _DESTROY_ROS_MESSAGE = _TYPE_SUPPORT = "not converted"

    @classmethod
    def __import_type_support__(cls) -> None:
        """Nothing to import."""


class _Message(metaclass=_Interface):
    """The base class of all messages."""

    __slots__ = ()
    _FIELDS: tuple[InterfaceField, ...] = ()
    SLOT_TYPES: tuple[Any, ...] = ()

    def __init__(self, **values: Any) -> None:
        values.pop("check_fields", None)
        names = [field.name for field in self._FIELDS]
        wrong = sorted(values.keys() - set(names))
        assert not wrong, f"Invalid arguments passed to constructor: {', '.join(wrong)}{nearest(wrong[0], names)}"
        for field in self._FIELDS:
            setattr(self, field.name, values[field.name] if field.name in values else _default(field))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, type(self)) and all(
            _equal(getattr(self, field.name), getattr(other, field.name)) for field in self._FIELDS
        )

    __hash__ = None  # type: ignore[assignment]  # it can change

    def __repr__(self) -> str:
        package, folder, *_ = type(self).__module__.split(".")
        values = ", ".join(f"{field.name}={getattr(self, field.name)!r}" for field in self._FIELDS)
        return f"{package}.{folder}.{type(self).__name__}({values})"

    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]:
        """Name of a field -> its type, as text."""
        return {field.name: _text(field.type) for field in cls._FIELDS}


def _equal(one: Any, other: Any) -> bool:
    same = one == other
    return bool(same.all()) if hasattr(same, "all") else bool(same)


def _text(kind: FieldType) -> str:
    package, _, rest = kind.name.partition("/")
    name = f"{package}/{rest.rpartition('/')[2]}" if rest else kind.name
    name += f"<{kind.max_length}>" if kind.max_length else ""
    if not kind.is_array:
        return name
    return f"{name}[{kind.size}]" if kind.is_fixed else f"sequence<{name}{f', {kind.size}' if kind.size else ''}>"


def _class(name: str) -> Any:
    """The class of a nested message. Raises Ros2Error if its package is not installed."""
    package, folder, class_name = name.split("/")
    try:
        return getattr(importlib.import_module(f"{package}.{folder}"), class_name)
    except ModuleNotFoundError:
        raise Ros2Error(
            f"ros2: type {name!r} is needed, but there is no Python package {package!r}: install it, or add the folder "
            "of its interface files to Ros2(interfaces=...)"
        ) from None


def _element(kind: FieldType) -> Any:
    """The default value of an element."""
    if kind.is_message:
        return _class(kind.name)()
    plain = _KINDS.get(kind.name, int)
    return b"\x00" if plain is bytes else plain()


def _default(field: InterfaceField) -> Any:
    kind = field.type
    if not kind.is_array:
        return _element(kind) if field.default is None else field.default
    values = field.default
    if values is None:
        values = [_element(kind) for _ in range(kind.size or 0)] if kind.is_fixed else []
    return _container(kind, copy.copy(values))


def _container(kind: FieldType, values: Any) -> Any:
    """Values in what `rosidl` keeps them in: numpy's array for a fixed number of numbers, Python's for any number."""
    code = _ARRAY_CODES.get(kind.name)
    if code is None:
        return list(values) if not isinstance(values, list) else values
    if kind.is_fixed:
        import numpy

        return numpy.array(values, dtype=code)
    return values if isinstance(values, array.array) and values.typecode == code else array.array(code, values)


def _setter(field: InterfaceField) -> Any:
    kind, slot = field.type, f"_{field.name}"

    def set_value(message: Any, value: Any) -> None:
        if kind.is_array:
            value = _check_array(field, value)
        else:
            _check(field.name, kind, value)
        setattr(message, slot, value)

    return set_value


def _check_array(field: InterfaceField, value: Any) -> Any:
    kind = field.type
    is_sequence = hasattr(value, "__len__") and hasattr(value, "__iter__") and not isinstance(value, (str, dict))
    fits = is_sequence and (
        kind.size is None or len(value) == kind.size or (not kind.is_fixed and len(value) < kind.size)
    )
    number = "" if kind.size is None else f" with {'' if kind.is_fixed else 'at most '}{kind.size} elements"
    assert fits, f"The '{field.name}' field must be a set or sequence{number} and each value of type '{kind.name}'"
    is_checked = isinstance(value, array.array) or hasattr(value, "dtype")
    for element in () if is_checked else value:
        _check(field.name, kind, element)
    try:
        return _container(kind, value)
    except (TypeError, OverflowError) as error:
        raise AssertionError(f"The '{field.name}' field must have values of type '{kind.name}': {error}") from None


def _check(name: str, kind: FieldType, value: Any) -> None:
    """Raises AssertionError for a value that is none of the type, as what `rosidl` generates does."""
    if kind.is_message:
        wanted = _class(kind.name)
        assert isinstance(value, wanted), f"The '{name}' field must be a sub message of type '{wanted.__name__}'"
        return
    plain = _KINDS.get(kind.name, int)
    is_of_type: bool = isinstance(value, plain)
    assert is_of_type, f"The '{name}' field must be of type '{plain.__name__}'"
    if plain is int:
        bits, signed = int(kind.name.lstrip("uint")), not kind.name.startswith("u")
        low, high = (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) if signed else (0, 2**bits - 1)
        assert low <= value <= high, f"The '{name}' field must be an integer in [{low}, {high}]"
    if kind.name == "float":
        fits = not abs(value) > _MAX_FLOAT32 or value in (float("inf"), float("-inf"))
        assert fits, f"The '{name}' field must be a float in [-{_MAX_FLOAT32}, {_MAX_FLOAT32}]"
    if kind.max_length is not None:
        assert len(value) <= kind.max_length, f"The '{name}' field must be of at most {kind.max_length} characters"


def slot_type(kind: FieldType) -> Any:
    """The type as in `rosidl_parser.definition`, as far as `messages` needs it."""
    if kind.is_message:
        *namespaces, name = kind.name.split("/")
        element: Any = SimpleNamespace(namespaces=namespaces, name=name)
    elif kind.name in ("string", "wstring"):
        element = type("UnboundedWString" if kind.name == "wstring" else "UnboundedString", (), {})()
    else:
        element = SimpleNamespace(typename=kind.name)
    if not kind.is_array:
        return element
    return SimpleNamespace(value_type=element, size=kind.size) if kind.is_fixed else SimpleNamespace(value_type=element)


def _message_class(module: str, name: str, part: Part) -> Any:
    """The class of a message."""
    members: dict[str, Any] = {
        "__slots__": tuple(f"_{field.name}" for field in part.fields),
        "__module__": module,
        "_FIELDS": part.fields,
        "SLOT_TYPES": tuple(slot_type(field.type) for field in part.fields),
        **dict(part.constants),
    }
    for field in part.fields:
        members[field.name] = property(partial(_get, f"_{field.name}"), _setter(field))
    return _Interface(name, (_Message,), members)


def _get(slot: str, message: Any) -> Any:
    return getattr(message, slot)


def _service_class(module: str, name: str, request: Part, response: Part) -> Any:
    """The class of a service, with its request, its response, and the event of introspection."""
    members = {
        "__module__": module,
        "Request": _message_class(module, f"{name}_Request", request),
        "Response": _message_class(module, f"{name}_Response", response),
    }
    package, folder, _ = module.split(".")
    info = InterfaceField("info", FieldType("service_msgs/msg/ServiceEventInfo"))
    both = [
        InterfaceField(part, FieldType(f"{package}/{folder}/{name}_{part.capitalize()}", is_array=True, size=1))
        for part in ("request", "response")
    ]
    members["Event"] = _message_class(module, f"{name}_Event", Part((info, *both)))
    return _Interface(name, (), members)


def _action_class(module: str, name: str, goal: Part, result: Part, feedback: Part) -> Any:
    """The class of an action, with the services and topics that it is made of (design article "Actions")."""
    package, folder, _ = module.split(".")
    parts = {"Goal": goal, "Result": result, "Feedback": feedback}
    classes = {key: _message_class(module, f"{name}_{key}", part) for key, part in parts.items()}
    goal_id = InterfaceField("goal_id", FieldType("unique_identifier_msgs/msg/UUID"))

    def part_field(key: str) -> InterfaceField:
        return InterfaceField(key.lower(), FieldType(f"{package}/{folder}/{name}_{key}"))

    stamp = InterfaceField("stamp", FieldType("builtin_interfaces/msg/Time"))
    send_goal = Part((goal_id, part_field("Goal"))), Part((InterfaceField("accepted", FieldType("boolean")), stamp))
    get_result = Part((goal_id,)), Part((InterfaceField("status", FieldType("int8")), part_field("Result")))
    impl = {
        "SendGoalService": _service_class(module, f"{name}_SendGoal", *send_goal),
        "GetResultService": _service_class(module, f"{name}_GetResult", *get_result),
        "FeedbackMessage": _message_class(module, f"{name}_FeedbackMessage", Part((goal_id, part_field("Feedback")))),
        "CancelGoalService": _class("action_msgs/srv/CancelGoal"),
        "GoalStatusMessage": _class("action_msgs/msg/GoalStatusArray"),
    }
    return _Interface(name, (), {"__module__": module, **classes, "Impl": type("Impl", (), impl)})


def _snake(name: str) -> str:
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name).lower()


_MAKERS: dict[str, Callable[..., Any]] = {"msg": _message_class, "srv": _service_class, "action": _action_class}


def class_of_file(file: Path, package: str, kind: str) -> Any:
    """The class of an interface file; `kind` is "msg", "srv" or "action". Raises Ros2Error for a mistake in it."""
    parts = parts_of(file.read_text(encoding="utf-8"), package, str(file))
    expected = 1 + FOLDERS.index(kind)
    if len(parts) != expected:
        raise Ros2Error(f"{file}: has {len(parts)} parts; expected {expected}, with lines `---` between them")
    return _MAKERS[kind](f"{package}.{kind}._{_snake(file.stem)}", file.stem, *parts)
