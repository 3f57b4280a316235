"""Parses and writes ROS arguments (`--ros-args`): the remappings and parameters of a process or a node.

`parse` returns `Arguments`, which each `Context` and each `GraphNode` has. `command_line` writes the arguments of a
declared `RosNode`, and `yaml_text` a parameter's value; `without_ros` leaves the arguments that are not for ROS.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from pytest_hricdv.declarations.ros2 import LaunchError, RosNode
from pytest_hricdv.extra.ros2.handles import RCLError

_START, _END = "--ros-args", "--"  # ROS arguments stand between these
_WITH_VALUE = ("--log-level", "--log-config-file", "--enclave", "-e", "--log-file-name")
# As in `--enable-stdout-logs`. These, and all of `_WITH_VALUE` but `--log-level`, have no effect in a run.
_SWITCHES = ("stdout-logs", "external-lib-logs")


class InvalidROSArgsError(RCLError):
    """Like `RCLInvalidROSArgsError` of `rclpy`'s extension: a ROS argument lacks its value, or has a wrong one."""


class UnknownROSArgsError(RuntimeError):
    """Like the error of `rclpy`'s extension: ROS does not know an argument."""


_TRUE = frozenset(["Y", "y", "yes", "Yes", "YES", "true", "True", "TRUE", "on", "On", "ON"])
_FALSE = frozenset(["N", "n", "no", "No", "NO", "false", "False", "FALSE", "off", "Off", "OFF"])
_INTEGER = re.compile(r"[+-]?(0[xX][0-9a-fA-F]+|[0-9]+)")
_FLOAT = re.compile(r"[+-]?(([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?|\.?(inf|nan|infinity))", re.IGNORECASE)
_INT64 = range(-(2**63), 2**63)


def _scalar(text: str) -> bool | int | float | str:
    """Parse an unquoted value as rcl does: YAML 1.1 would read dates, `1:30` as 90, and `1e-3` as a text."""
    if text in _TRUE or text in _FALSE:
        return text in _TRUE
    if _INTEGER.fullmatch(text):
        digits = text.lstrip("+-")
        base = (
            16 if digits[:2] in ("0x", "0X") else 8 if digits.startswith("0") and set(digits) <= set("01234567") else 10
        )
        number = int(text, base)
        if number in _INT64 and (base != 10 or digits == "0" or not digits.startswith("0")):
            return number
    return float(text.replace(".inf", "inf").replace(".nan", "nan")) if _FLOAT.fullmatch(text) else text


_PLAIN = "!without-quotes"


class _Loader(yaml.SafeLoader):
    """Reads YAML as rcl does."""

    def resolve(self, kind: type[Any], value: Any, implicit: Any) -> Any:
        """The tag of a node: of its own for a scalar without quotes and without a tag."""
        if kind is yaml.ScalarNode and implicit[0]:
            return _PLAIN
        return super().resolve(kind, value, implicit)  # type: ignore[no-untyped-call]


_Loader.add_constructor(_PLAIN, lambda loader, node: _scalar(str(node.value)))


def _fault(fault: str) -> InvalidROSArgsError:
    return InvalidROSArgsError(f"Failed to parse ROS arguments: {fault}")


@dataclass(frozen=True)
class _Rule:
    """A remapping of one node, or of all ("")."""

    node: str
    source: str
    target: str


@dataclass
class Arguments:
    """The parsed ROS arguments. Names of nodes are patterns: `*` is one token, `**` any number of them."""

    remappings: list[_Rule] = field(default_factory=list)
    parameters: list[tuple[str, str, Any]] = field(default_factory=list)
    """Pattern of the node, name of the parameter, value; later ones win."""
    log_levels: list[tuple[str, str]] = field(default_factory=list)
    """Name of a logger, or "" for all of them, and its level, such as "warn"; later ones win."""
    rosout: bool = True
    """Whether logs are published."""

    def new_name(self, source: str, node: str) -> str | None:
        """The new name of a node (`source` is "__node") or its namespace ("__ns"); None if it keeps its own."""
        for rule in self.remappings:
            if rule.source == source and rule.node in ("", node):
                return rule.target
        return None

    def parameters_of(self, node: str) -> dict[str, Any]:
        """The parameters of a node, by its full name."""
        return {name: value for pattern, name, value in self.parameters if matches_node(pattern, node)}


def matches_node(pattern: str, node: str) -> bool:
    """Whether a node is meant, by its full name: `*` stands for one token of it, `**` for any number."""
    absolute = pattern if pattern.startswith("/") else f"/{pattern}"
    # `**` first: `*` is a part of it.
    regex = re.escape(absolute).replace(r"/\*\*", r"(/\w+)*").replace(r"/\*", r"/\w+")
    return re.fullmatch(regex, node) is not None


def parse(arguments: Sequence[str]) -> Arguments:
    """Read the ROS arguments among the arguments of a process.

    Raises:
        InvalidROSArgsError: one lacks its value, or has a wrong one.
        UnknownROSArgsError: one is not known.
        UnicodeEncodeError: an argument is not text.
    """
    for word in arguments:
        word.encode()  # as the extension, which refuses what has half a surrogate pair
    parsed, unknown = Arguments(), []
    rest = list(arguments)
    is_ros = False
    while rest:
        word = rest.pop(0)
        # Between --ros-args and --, or the end; several times, as launch files append their own.
        if not is_ros or word in (_START, _END):
            is_ros = word == _START or (is_ros and word != _END)
            continue
        value = _value(word, rest)
        if word in ("-p", "--param"):
            _add_parameter(parsed, value)
        elif word in ("-r", "--remap"):
            parsed.remappings.append(_rule(value))
        elif word == "--params-file":
            _add_file(parsed, value)
        elif word == "--log-level":
            parsed.log_levels.append(_level(value))
        elif word in ("--enable-rosout-logs", "--disable-rosout-logs"):
            parsed.rosout = word.startswith("--enable")
        elif word not in _WITH_VALUE and not _is_switch(word):
            unknown.append(word)
    if unknown:
        raise UnknownROSArgsError(f"Found unknown ROS arguments: {unknown}")
    return parsed


def without_ros(arguments: Sequence[str]) -> list[str]:
    """The arguments that are not for ROS, as `rclpy_remove_ros_args`."""
    kept, is_ros = [], False
    for word in arguments:
        if word == _START:
            is_ros = True
        elif is_ros and word == _END:
            is_ros = False
        elif not is_ros:
            kept.append(word)
    return kept


def _is_switch(word: str) -> bool:
    return any(word in (f"--enable-{name}", f"--disable-{name}") for name in _SWITCHES)


def _value(word: str, rest: list[str]) -> str:
    if word not in (*_WITH_VALUE, "-p", "--param", "-r", "--remap", "--params-file"):
        return ""
    if not rest or rest[0] == _START:
        raise _fault(f"'{word}' has no value")
    return rest.pop(0)


def _split(text: str) -> tuple[str, str, str]:
    """Node, name and value of `node:name:=value`."""
    name, separator, value = text.partition(":=")
    if not separator or not name:
        raise _fault(f"'{text}' is not of the form name:=value")
    scheme = next((prefix for prefix in ("rostopic://", "rosservice://") if name.startswith(prefix)), "")
    node, colon, inner = name[len(scheme) :].partition(":")
    return (node, inner, value) if colon else ("", name[len(scheme) :], value)


_LEVELS = ("UNSET", "DEBUG", "INFO", "WARN", "ERROR", "FATAL")


def _level(text: str) -> tuple[str, str]:
    """Logger and level of `level` or `logger:=level`."""
    logger, separator, level = text.rpartition(":=")
    if level.upper() not in _LEVELS or (separator and not logger):
        raise _fault(f"'{text}' is not a level of a logger; levels: {', '.join(_LEVELS)}")
    return logger, level


def _rule(text: str) -> _Rule:
    node, source, target = _split(text)
    return _Rule(node, source, target)


def _add_parameter(parsed: Arguments, text: str) -> None:
    node, name, value = _split(text)
    try:
        parsed.parameters.append((node or "/**", name, yaml.load(value, Loader=_Loader)))  # a safe one
    except yaml.YAMLError as error:
        raise _fault(f"'{text}' is not YAML: {' '.join(str(error).split())}") from None


def _add_file(parsed: Arguments, path: str) -> None:
    try:
        root = yaml.compose(Path(path).read_text(encoding="utf-8"), Loader=_Loader)
        if root is not None:
            _add_nodes(parsed, "", root, path)
    except OSError as error:
        raise _fault(f"parameter file {Path(path).absolute()}: {error.strerror}") from None
    except yaml.MarkedYAMLError as error:
        line = "" if error.problem_mark is None else f":{error.problem_mark.line + 1}"
        raise _fault(f"parameter file {path}{line}: {error.problem}") from None
    except (ValueError, yaml.YAMLError) as error:
        raise _fault(f"parameter file {path}: {' '.join(str(error).split())}") from None


def _pairs(node: Any, path: str) -> list[tuple[str, Any]]:
    """Keys and values of a mapping. Not as a dictionary: such files have the same pattern of names several times."""
    if not isinstance(node, yaml.MappingNode):
        raise _fault(f"parameter file {path}:{node.start_mark.line + 1}: expected names with values below them")
    return [(str(key.value), value) for key, value in node.value]


def _add_nodes(parsed: Arguments, above: str, node: Any, path: str) -> None:
    for name, body in _pairs(node, path):
        if name == "ros__parameters":
            _add_values(parsed, above, "", body, path)
        else:
            _add_nodes(parsed, f"{above}/{name.lstrip('/')}", body, path)


def _add_values(parsed: Arguments, node: str, above: str, values: Any, path: str) -> None:
    for name, value in _pairs(values, path):
        if isinstance(value, yaml.MappingNode):
            _add_values(parsed, node, f"{above}{name}.", value, path)
        else:
            # Construct from the node, not from its text: quotes matter.
            read = _Loader("").construct_object(value, deep=True)
            parsed.parameters.append((node, f"{above}{name}", read))


def command_line(node: RosNode) -> list[str]:
    """`sys.argv` of the process of a node.

    Raises:
        LaunchError: a parameter that ROS has no type for.
    """
    rules = [("__node", node.name), ("__ns", node.namespace)]
    remapped = [f"{source}:={target}" for source, target in [*rules, *node.remappings] if target]
    ros = [word for rule in remapped for word in ("-r", rule)]
    for parameters in node.parameters:
        if isinstance(parameters, Mapping):
            ros += [word for name, value in _flat(node, "", parameters) for word in ("-p", f"{name}:={value}")]
        else:
            ros += ["--params-file", str(parameters)]
    return [node.executable or node.label, *node.arguments, *(["--ros-args", *ros] if ros else [])]


def _flat(node: RosNode, above: str, parameters: Mapping[str, Any]) -> list[tuple[str, str]]:
    flat = []
    for name, value in parameters.items():
        if isinstance(value, Mapping):
            flat += _flat(node, f"{above}{name}.", value)
        else:
            flat.append((f"{above}{name}", yaml_text(node, f"{above}{name}", value)))
    return flat


def yaml_text(node: RosNode, name: str, value: Any) -> str:
    """A value of a parameter as a command line has it. Raises LaunchError for one that ROS has no type for."""
    if isinstance(value, bool):  # before int, which it is, too
        return str(value).lower()
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return _yaml_float(value)
    if isinstance(value, str):
        return "'" + value.replace("'", "''") + "'"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(yaml_text(node, name, element) for element in value) + "]"
    raise LaunchError(f"{node}: parameter {name!r} is {value!r}; expected a bool, a number, a string, or a list")


def _yaml_float(value: float) -> str:
    """Read a float as YAML 1.1: with a point, and a sign in the exponent."""
    if not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    mantissa, e, exponent = repr(value).partition("e")
    return (mantissa if "." in mantissa else f"{mantissa}.0") + (e + exponent if e else "")
