"""Reads the fields of ROS 2 messages, requests and goals from their interface files, for drafts; imports nothing."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from importlib.machinery import PathFinder
from pathlib import Path
from typing import Any

from pytest_hricdv.extra.draft.code.naming import unit_of
from pytest_hricdv.extra.draft.code_model import CodeLine, MessageField

MAX_NUMBERS = 6
"""Most numbers of a message that are drawn, as many as a pose has; the others have their defaults."""

_MAX_DEPTH = 3
_STAMPS = ("std_msgs/msg/Header", "builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration")
_KINDS = {"bool": "bool", "string": "str", "wstring": "str", "float32": "float", "float64": "float"}

_Fields = Sequence[tuple[str, Any]]
"""Names and types of a definition, as `rosbags` reads them."""


def interface_file(kind: str, packages: Mapping[str, Path]) -> Path | None:
    """The file of a type such as "std_msgs/msg/Bool", of the workspace or installed; None if there is none."""
    package, folder, name = kind.split("/")
    prefixes = [Path(sys.prefix), *(Path(path) for path in os.environ.get("AMENT_PREFIX_PATH", "").split(":") if path)]
    shares = [packages[package]] if package in packages else []
    shares += [prefix / "share" / package for prefix in (*prefixes, *_install_prefixes(package))]
    files = [share / folder / f"{name}.{folder}" for share in shares]
    return next((file for file in files if file.is_file()), None)


def _install_prefixes(package: str) -> Sequence[Path]:
    """The folders around an installed package, one of which has its `share` beside its `lib`."""
    spec = PathFinder.find_spec(package)
    return Path(spec.origin).parents if spec is not None and spec.origin is not None else ()


def is_installed(package: str) -> bool:
    """Whether a package can be imported, found without doing so; a folder of interface files on the path cannot."""
    spec = PathFinder.find_spec(package)
    return spec is not None and spec.origin is not None


def fields(kind: str, part: int, packages: Mapping[str, Path], location: CodeLine) -> tuple[MessageField, ...] | None:
    """The fields of a message, or of the first or a later part of a service or an action.

    Args:
        part: 0 for a message, a request, a goal; 1 for a response, a result.
        location: the location that the fields get: where the code uses the type.

    Returns:
        Its truths, strings and numbers, those of messages in it by paths (`linear.x`); None if no file declares them.
    """
    definition = _definition(kind, part, packages)
    if definition is None:
        return None
    numbers = 0
    chosen: list[MessageField] = []
    depth = 0 if kind.split("/")[1] == "msg" else _MAX_DEPTH
    for field in _fields(definition, "", depth, packages, location):
        numbers += field.kind == "float" and field.type != "list"  # a scan without its ranges says nothing
        if field.kind != "float" or field.type == "list" or numbers <= MAX_NUMBERS:
            chosen.append(field)
    return tuple(chosen)


def _definition(kind: str, number: int, packages: Mapping[str, Path]) -> _Fields | None:
    """The fields of a message, or of a part of a service or an action; None if no file defines it."""
    from rosbags.typesys import TypesysError, get_types_from_msg

    file = interface_file(kind, packages)
    try:
        text = file.read_text(encoding="utf-8") if file is not None else ""
        parts = re.split(r"^---.*$", text, flags=re.MULTILINE)
        # `wstring` is none of its basic types.
        types = get_types_from_msg(
            re.sub(r"\bwstring\b", "string", parts[number]), f"{kind.partition('/')[0]}/msg/Part"
        )
    except (OSError, ValueError, IndexError, TypesysError):
        return None
    return next(iter(types.values()))[1] if file is not None else None


def _fields(
    definition: _Fields, prefix: str, depth: int, packages: Mapping[str, Path], location: CodeLine
) -> Iterator[MessageField]:
    for own_name, (sort, content) in definition:
        name = f"{prefix}{own_name}"
        if sort.name == "NAME":
            inner = None
            if depth < _MAX_DEPTH and content not in _STAMPS:
                inner = _definition(content, 0, packages)
            if inner is not None:
                yield from _fields(inner, f"{name}.", depth + 1, packages, location)
            continue
        field = _field(sort.name, content, name, location)
        if field is not None and (field.kind == "float" or not prefix):
            yield field


def _field(sort: str, content: Any, name: str, location: CodeLine) -> MessageField | None:
    """A field; of arrays, only those of floating numbers without a fixed length, which have one value together."""
    unit = _unit(name.rpartition(".")[2])
    if sort != "BASE":
        inner, inner_content = content[0]
        is_drawn = sort == "SEQUENCE" and inner.name == "BASE" and inner_content[0] in ("float32", "float64")
        return MessageField(name, "list", "float", location, unit=unit) if is_drawn else None
    kind = _KINDS.get(content[0], "float")
    is_integer = kind == "float" and content[0] not in _KINDS
    return MessageField(name, "int" if is_integer else kind, kind, location, unit=unit)


def _unit(name: str) -> str:
    """The unit that a field's name says; `angle_min` is the least angle, and in no minutes."""
    return "" if name.endswith("_min") else unit_of(name)
