"""Reads ROS 2 bags and MCAP files: `read_messages` yields their messages, and a `Decoder` decodes them.

`recording` uses both. Messages are CDR, decoded by the definitions of their types, or JSON.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any

import msgspec

from pytest_hricdv._base.error_text import OvertimeError, call_within, error_text
from pytest_hricdv._base.input_file import MAX_DEPTH
from pytest_hricdv.recordings.containers import BagMessage, UnreadableError, read_mcap, read_sqlite, write_ahead_log

Value = bool | float | str | tuple[float, ...]
"""The value of a field, or the numbers of an array."""

Paths = Mapping[str, tuple[str, ...]]
"""Fields as paths, each with the names along the path."""

MAX_ELEMENTS = 1000
"""Maximum number of elements of an array that are decoded: an image has millions."""

SUFFIXES = (".mcap", ".db3")

EMPTY_BYTES = 8
"""Maximum size (bytes) of a message without fields, whose definition is empty: a header and a placeholder."""

MAX_EXACT = 2**53
"""Integers below this one are exact as floats."""

MAX_DEFINITION = 1_000_000
"""Maximum length (characters) of the definition of a type, with the types that it uses: a hundred times a long one."""

DEFINED_WITHIN_S = 10.0
"""Time limit (s of real time) for reading the definition of a type; a long one takes milliseconds."""


def bag_files(path: Path) -> list[Path]:
    """The files of a bag, in order.

    Raises:
        UnreadableError: it is not a bag.
    """
    if not path.is_dir():
        if path.suffix not in SUFFIXES:
            raise UnreadableError(f"{path.name}: the file is neither *.mcap nor *.db3")
        return [path]
    for suffix in SUFFIXES:
        if files := sorted(path.glob(f"*{suffix}"), key=_natural):
            return files
    if any(path.glob("*.db3*")):
        raise UnreadableError(f"{path.name}: its files are compressed; unpack them, as with: zstd -d *.zstd")
    raise UnreadableError(f"{path.name}: no file *.mcap or *.db3 is in this folder")


def _natural(file: Path) -> list[tuple[int, str]]:
    """The sort key of names as people sort them: `run_2` before `run_10`."""
    return [(int(part[:18]), "") if part.isdigit() else (0, part) for part in re.split(r"([0-9]+)", file.name)]


def read_messages(file: Path) -> Iterator[BagMessage]:
    """The messages of a file, up to the first error.

    Raises:
        UnreadableError: the rest cannot be read.
    """
    if not file.is_file():  # opening a pipe would wait for ever
        raise UnreadableError(f"{file.name}: there is no such file, or it is a folder, a pipe or a device")
    if file.suffix != ".mcap" and (log := write_ahead_log(file)):
        raise UnreadableError(
            f"{log.name} has messages that are not in the database yet, as after an interrupted recording; merge them: "
            f"sqlite3 {log.name.removesuffix('-wal')} 'PRAGMA wal_checkpoint(TRUNCATE)'"
        )
    try:
        yield from read_mcap(file) if file.suffix == ".mcap" else read_sqlite(file)
    except UnreadableError as error:
        text = str(error)
        raise UnreadableError(text if text.startswith(file.name) else f"{file.name}: {text}") from None
    except Exception as error:  # each library has errors of its own
        kind = "not an MCAP file that can be read" if file.suffix == ".mcap" else "not a database that can be read"
        raise UnreadableError(f"{file.name}: {kind}, or cut off: {error_text(error)}") from None


class Decoder:
    """Decodes messages.

    Args:
        file_of: type such as "std_msgs/msg/Bool" -> its interface file, for bags without definitions; None if there is
            none.
    """

    def __init__(self, file_of: Callable[[str], Path | None]) -> None:
        from rosbags.typesys import Stores, get_typestore

        self._file_of = file_of
        self._types = get_typestore(Stores.EMPTY)
        self._readers: dict[str, Callable[[bytes], Any]] = {}

    def fields(self, message: BagMessage, paths: Paths | None = None) -> dict[str, Value]:
        """The fields of a message, of inner messages by paths (`linear.x`).

        Args:
            paths: the fields to decode; None for all.

        Raises:
            UnreadableError: its type is not known, or its bytes do not match the type.
        """
        content = self._content(message)
        if paths is None:
            return dict(_flat(content if type(content) is dict else _attributes(content), ""))
        picked: dict[str, Value] = {}
        for path, names in paths.items():
            value: Any = content
            for name in names:
                value = value.get(name) if type(value) is dict else getattr(value, name, None)
            kind = type(value)
            if kind is float or kind is bool or kind is str:  # nearly always: without a call of a function
                picked[path] = value
            elif kind is int and -MAX_EXACT < value < MAX_EXACT:
                picked[path] = float(value)
            elif value is not None:
                picked.update(_flat({path: value}, ""))
        return picked

    def _content(self, message: BagMessage) -> Any:
        """The message as a mapping (JSON) or an object (CDR)."""
        _, kind, encoding, definition = message.topic
        if encoding == "json":
            return _parse_json(message.data)
        if encoding != "cdr":
            named = encoding or "in a format without a name"
            raise UnreadableError(f"its messages are {named}; expected cdr or json")
        read = self._readers.get(kind)
        if read is None and not definition and len(message.data) <= EMPTY_BYTES and self._file_of(kind) is None:
            return {}
        if read is None:
            self._add(kind, definition)
        try:
            if read is None:
                read = self._readers[kind] = self._reader_of(kind)
            return read(message.data)
        except KeyError as error:
            raise _type_error(str(error).strip("'")) from None
        except Exception as error:  # of its reader there are several
            raise UnreadableError(f"its bytes are not a {kind}: {error_text(error)}") from None

    def _reader_of(self, kind: str) -> Callable[[bytes], Any]:
        return lambda data: self._types.deserialize_cdr(data, kind)

    def _add(self, kind: str, definition: str) -> None:
        """Add the definition of a type and of those that it uses."""
        from rosbags.typesys import TypesysError, get_types_from_msg

        if kind in self._types.fielddefs:
            return
        text = definition
        if not text:
            file = self._file_of(kind) if kind.count("/") == 2 else None
            if file is None:
                raise _type_error(kind)
            text = file.read_text(encoding="utf-8")
        if len(text) > MAX_DEFINITION:
            raise UnreadableError(f"type {kind}: its definition has more than {MAX_DEFINITION:,} characters")
        try:
            types = call_within(DEFINED_WITHIN_S, lambda: get_types_from_msg(text, kind))
            self._types.register({name: made for name, made in types.items() if name not in self._types.fielddefs})
        except OvertimeError:
            raise UnreadableError(
                f"type {kind}: reading its definition takes more than {DEFINED_WITHIN_S:g} s"
            ) from None
        except (TypesysError, KeyError, ValueError, RecursionError) as error:
            raise UnreadableError(f"type {kind}: {error_text(error)}") from None
        for _, (_, fields) in types.items() if not definition else ():
            for inner in (field for _, field in fields):
                named = _type_name(inner)
                if named:
                    self._add(named, "")


def _type_error(kind: str) -> UnreadableError:
    return UnreadableError(f"type {kind or 'unknown'} is defined neither in the file nor here: install its package")


def _type_name(field: Any) -> str:
    """The message type of a field, or of the elements of an array; empty for numbers and strings."""
    kind, content = field
    if kind.name == "NAME":
        return str(content)
    return _type_name(content[0]) if kind.name in ("ARRAY", "SEQUENCE") else ""


def _parse_json(data: bytes) -> Mapping[str, Any]:
    try:
        content = msgspec.json.decode(data)
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError):
        content = _parse_tolerantly(data)
    if not isinstance(content, dict):
        raise UnreadableError("its JSON is not an object")
    return content


def _parse_tolerantly(data: bytes) -> Any:
    """Parse JSON with NaN and infinity, as Python writes them."""
    try:
        return json.loads(data)
    except (ValueError, RecursionError):
        raise UnreadableError("its bytes are not JSON") from None


def _attributes(content: Any) -> Mapping[str, Any]:
    return {name: value for name, value in vars(content).items() if not name.startswith("__")}


def _flat(content: Mapping[str, Any], above: str, depth: int = 0) -> Iterator[tuple[str, Value]]:
    if depth > MAX_DEPTH:
        raise UnreadableError(f"nested too deeply; expected a depth of at most {MAX_DEPTH}")
    for name, value in content.items():
        path = f"{above}{name}"
        if is_dataclass(value):
            yield from _flat(_attributes(value), f"{path}.", depth + 1)
        elif isinstance(value, Mapping):
            yield from _flat(value, f"{path}.", depth + 1)
        elif isinstance(value, bool | str):
            yield path, value
        elif isinstance(value, int | float):
            yield path, _number(value)
        elif hasattr(value, "tolist") or isinstance(value, list):
            elements = _sample(value.tolist() if hasattr(value, "tolist") else value)
            if elements and all(type(element) in (int, float) for element in elements):
                yield path, tuple(map(_number, elements))


def _number(value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        raise UnreadableError("a number of more than 308 digits") from None


def _sample(values: list[Any]) -> list[Any]:
    """The elements of an array; for a long one, its extremes and evenly spaced elements."""
    step = -(-len(values) // MAX_ELEMENTS)
    if step <= 1 or not isinstance(values[0], int | float):
        return values[:MAX_ELEMENTS]
    numbers = [value for value in values if isinstance(value, int | float)]
    return [min(numbers), max(numbers), *numbers[::step]]
