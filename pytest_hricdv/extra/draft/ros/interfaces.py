"""The fields of messages, requests and goals of ROS 2, as their interface files say them; nothing is imported."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from importlib.machinery import PathFinder
from pathlib import Path

from pytest_hricdv.declarations.ros2 import Ros2Error
from pytest_hricdv.extra.draft.found.findings import MessageField, Place
from pytest_hricdv.extra.draft.reading.naming import unit_of
from pytest_hricdv.extra.ros2.interface_text import Field, Part, parts_of
from pytest_hricdv.extra.ros2.packages import SourcePackage

MOST_NUMBERS = 6
"""So many numbers of a message are drawn (chosen: a pose); the others have their defaults."""

_DEPTH = 3
_STAMPS = ("std_msgs/msg/Header", "builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration")
_KINDS = {"boolean": "bool", "string": "str", "wstring": "str", "float": "float", "double": "float"}


def interface_file(kind: str, packages: Mapping[str, SourcePackage]) -> Path | None:
    """The file of a type such as "std_msgs/msg/Bool", of the workspace or installed; None if there is none."""
    package, folder, name = kind.split("/")
    prefixes = [Path(sys.prefix), *(Path(path) for path in os.environ.get("AMENT_PREFIX_PATH", "").split(":") if path)]
    shares = [packages[package].folder] if package in packages else []
    shares += [prefix / "share" / package for prefix in (*prefixes, *_installed_in(package))]
    files = [share / folder / f"{name}.{folder}" for share in shares]
    return next((file for file in files if file.is_file()), None)


def _installed_in(package: str) -> Sequence[Path]:
    """The folders around an installed package, one of which has its `share` beside its `lib`."""
    spec = PathFinder.find_spec(package)
    return Path(spec.origin).parents if spec is not None and spec.origin is not None else ()


def interface_files(folders: Iterable[Path]) -> Callable[[str], Path | None]:
    """Finds the file of a type as `interface_file`, where these are the folders of packages."""
    packages = {folder.name: SourcePackage(folder.name, folder) for folder in folders}
    return lambda kind: interface_file(kind, packages)


def is_installed(package: str) -> bool:
    """Whether a package can be imported; it is not. A folder of interface files, on the path, is no package."""
    spec = PathFinder.find_spec(package)
    return spec is not None and spec.origin is not None


def fields(
    kind: str, part: int, packages: Mapping[str, SourcePackage], place: Place
) -> tuple[MessageField, ...] | None:
    """What can be set of a message, or of the first or a later part of a service or an action.

    Args:
        part: 0 for a message, a request, a goal; 1 for a response, a result.
        place: that the fields have: where the code uses the type.

    Returns:
        Its truths, texts and numbers, those of messages in it by paths (`linear.x`); None where no file says them.
    """
    definition = _part(kind, part, packages)
    if definition is None:
        return None
    numbers = 0
    chosen: list[MessageField] = []
    for made in _fields(definition, "", 0 if kind.split("/")[1] == "msg" else _DEPTH, packages, place):
        numbers += made.kind == "float" and made.type != "list"  # a scan without its ranges says nothing
        if made.kind != "float" or made.type == "list" or numbers <= MOST_NUMBERS:
            chosen.append(made)
    return tuple(chosen)


def _part(kind: str, number: int, packages: Mapping[str, SourcePackage]) -> Part | None:
    file = interface_file(kind, packages)
    if file is None:
        return None
    try:
        parts = parts_of(file.read_text(encoding="utf-8"), kind.partition("/")[0], str(file))
    except (OSError, ValueError, Ros2Error):
        return None
    return parts[number] if number < len(parts) else None


def _fields(
    part: Part, prefix: str, depth: int, packages: Mapping[str, SourcePackage], place: Place
) -> Iterator[MessageField]:
    for entry in part.fields:
        name = f"{prefix}{entry.name}"
        if entry.type.is_message:
            inner = None
            if depth < _DEPTH and not entry.type.is_array and entry.type.name not in _STAMPS:
                inner = _part(entry.type.name, 0, packages)
            if inner is not None:
                yield from _fields(inner, f"{name}.", depth + 1, packages, place)
            continue
        made = _field(entry, name, place)
        if made is not None and (made.kind == "float" or not prefix):
            yield made


def _field(entry: Field, name: str, place: Place) -> MessageField | None:
    """A field; of numbers of which there are many, only floating ones, which have one value together."""
    kind = _KINDS.get(entry.type.name, "float")
    if entry.type.is_array:
        if entry.type.name not in ("float", "double") or entry.type.is_fixed:
            return None
        return MessageField(name, "list", "float", place, unit=_unit(entry.name))
    is_whole = kind == "float" and entry.type.name not in _KINDS
    return MessageField(name, "int" if is_whole else kind, kind, place, unit=_unit(entry.name))


def _unit(name: str) -> str:
    """The unit that a field's name says; `angle_min` is the least angle, and in no minutes."""
    return "" if name.endswith("_min") else unit_of(name)
