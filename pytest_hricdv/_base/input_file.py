"""Reads untrusted input files: limits their size and depth, and checks them before they are parsed.

A file from a user, a colleague or a CI service may be cut off, edited, or not a regular file. All modules that read
one use these functions: `read_text` and `read_bytes` read it, `from_json` and `from_toml` parse it. So all files have
the same limits, and each mistake in one is a `MalformedError` with its location.
"""

from __future__ import annotations

import math
import os
import re
import stat
import zlib
from collections.abc import Collection, Iterable, Iterator
from pathlib import Path
from typing import Any, TypeVar

from pytest_hricdv._base.message import InputError, nearest, quote

MAX_BYTES = 20_000_000
"""Maximum size (bytes) of a file of tests, a replay file or a table: a hundred times that of a large suite. Reading a
larger one would take too long."""

MAX_REPORT_BYTES = 500_000_000
"""Maximum size (bytes) of a report or a baseline, which contain every run of a suite: enough for 20,000 long runs."""

MAX_TOML_BYTES = 1_000_000
"""Maximum size (bytes) of a TOML file, which people write by hand: a thousand requirements. More takes seconds."""

MAX_UNPACKED_BYTES = 200_000_000
"""Maximum size (bytes) of one test's result after decompression: a hundred times that of a long test. Two megabytes of
zlib data can expand to two gigabytes."""

MAX_DEPTH = 64
"""Maximum depth of nested lists and tables: ten times that of any file here, and safe for Python's stack."""

MAX_DIGITS = 19
"""Maximum number of digits of an integer: seeds have 63 bits. Python needs seconds to parse a million digits."""

_BLOCK = 1_000_000
"""Minimum number of bytes to read, since the size of some files with content is reported as 0, as in /proc."""

T = TypeVar("T")

_PARTS = re.compile(
    r'"(?:[^"\\\n]|\\.)*+"|(?P<number>(?<![\w.])[-+]?\d[\d_]*+(?![.\w]))|(?P<word>(?<![\w.])-?(?:NaN|Infinity)\b)'
    r"|(?P<open>[\[{])|(?P<close>[\]}])"
)
_KEY = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_DEEP_KEY = re.compile(rf"(?<![\w.-]){_KEY}(?:[ \t]*+\.[ \t]*+{_KEY}){{{MAX_DEPTH}}}")
"""Matches a dotted TOML key with too many parts, for which `tomllib` needs time quadratic in its length."""
_ZEROS = bytes.maketrans(b"123456789", b"000000000")


class MalformedError(InputError, ValueError):
    """A file is not what it should be.

    The message is to follow the file's name: `:3:7: not JSON ...`, or `: Expected ... - at $.tests[3].outcome`.
    """


class EncodingError(MalformedError):
    """A file is not UTF-8.

    Args:
        line: the line of the first byte that is not, from 1.
        column: the column of that byte, from 1.
        byte: its value.
    """

    def __init__(self, line: int, column: int, byte: int) -> None:
        super().__init__(f":{line}:{column}: not UTF-8 text: byte 0x{byte:02x}")
        self.line = line
        self.column = column


def read_text(path: Path, most: int = MAX_BYTES) -> str:
    """The text of a UTF-8 file, with plain line ends and without a byte order mark.

    Args:
        most: its greatest size, in bytes.

    Raises:
        FileNotFoundError: there is none.
        MalformedError: it is a folder, a pipe or a device, unreadable, or too large.
        EncodingError: it is not UTF-8.
    """
    return decode_text(read_bytes(path, most))


def decode_text(data: bytes) -> str:
    """The text of the bytes of a UTF-8 file; raises as `read_text`."""
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        line, column = before.count(b"\n") + 1, error.start - (before.rfind(b"\n") + 1) + 1
        raise EncodingError(line, column, data[error.start]) from None
    return with_plain_ends(text.removeprefix("\ufeff"))


def with_plain_ends(text: str) -> str:
    """The text with the line ends of Unix."""
    return text.replace("\r\n", "\n").replace("\r", "\n")


def read_bytes(path: Path, most: int = MAX_BYTES) -> bytes:
    """The content of a file. Raises the same errors as `read_text`, whatever the bytes are."""
    try:
        kind = path.stat().st_mode
        if not stat.S_ISREG(kind):  # opening a pipe would wait for ever, and a device may have no end
            kind_of_file = "a folder" if stat.S_ISDIR(kind) else "not a regular file but a pipe, socket or device"
            raise MalformedError(f": {kind_of_file}; expected a file")
        with path.open("rb") as file:
            size = os.fstat(file.fileno()).st_size
            data = b"" if size > most else file.read(max(size, _BLOCK) + 1)  # files of /proc have contents, but no size
    except (FileNotFoundError, MalformedError):
        raise
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        raise MalformedError(f": cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if max(size, len(data)) > most or len(data) > max(size, _BLOCK):
        raise MalformedError(f": too large: {max(size, len(data)):,} bytes; expected at most {most:,}")
    return data


def unpack(data: bytes, most: int = MAX_UNPACKED_BYTES) -> bytes:
    """Decompress zlib data, with at most `most` bytes of it in memory.

    Raises:
        MalformedError: it has more, is cut off, or is not zlib data.
    """
    unpacking = zlib.decompressobj()
    try:
        content = unpacking.decompress(data, most + 1)
    except zlib.error as error:
        raise MalformedError(f": cannot be unpacked: {error}") from None
    if len(content) > most:
        raise MalformedError(f": unpacks to too much; expected at most {most:,} bytes")
    if not unpacking.eof or unpacking.unused_data:
        raise MalformedError(": cannot be unpacked: it is truncated, or has trailing data")
    return content


def from_json(text: str, kind: type[T], *, strict: bool = False) -> T:
    """A value of this type from the text of a JSON file; the type is its schema.

    Args:
        kind: a type that msgspec reads.
        strict: whether it has no keys but those of the type. A report of a later version may have more.

    Raises:
        MalformedError: the text is not JSON, or other JSON than `kind` has, or has a number that is too large.
    """
    import msgspec  # not at the top: a session that reads no file does not need it

    if _may_have_long_number(text) and (fault := _limit_fault(text)):  # msgspec's limit is that of a float
        raise MalformedError(fault)
    try:
        value = msgspec.json.decode(text, type=kind)
        if strict:
            check_keys_of(kind, msgspec.json.decode(text))
        return value
    except msgspec.ValidationError as error:  # also raised for the valid beginning of a text that is no JSON
        raise MalformedError(_json_fault(text) or f": {error}") from None
    except RecursionError:
        raise MalformedError(_limit_fault(text) or ": nested too deeply") from None
    except (msgspec.DecodeError, UnicodeEncodeError) as error:  # the latter: a lone surrogate in the text
        raise MalformedError(_json_fault(text) or f": not JSON: {error}") from None


def check_keys_of(kind: Any, value: object) -> None:
    """See that plain data has no keys but the fields of a type, here and below. Raises MalformedError."""
    import msgspec.inspect

    _check_keys("$", value, msgspec.inspect.type_info(kind))


def _check_keys(place: str, value: object, kind: Any) -> None:
    """See that objects have no other keys than the fields of their types. Raises MalformedError for the first one.

    Args:
        place: the place of the value, as msgspec's errors have it.
        value: plain data, of the kind.
        kind: the type, as `msgspec.inspect` describes it.
    """
    kinds: list[Any] = [part for part in getattr(kind, "types", (kind,)) if hasattr(part, "fields")] or [kind]
    if isinstance(value, dict) and len(kinds) == 1 and hasattr(kinds[0], "fields"):
        fields = {field.encode_name: field.type for field in kinds[0].fields}
        tag = getattr(kinds[0], "tag_field", None)
        for key, part in value.items():
            if key not in fields and key != tag and (place, key) != ("$", "schema"):  # whose reader has looked at that
                raise MalformedError(f": unknown key {quote(key)}{nearest(key, fields)} - at `{place}`")
            if key in fields:
                _check_keys(f"{place}.{key}", part, fields[key])
    elif isinstance(value, dict) and hasattr(kind, "value_type"):
        for key, part in value.items():
            _check_keys(f"{place}.{key}", part, kind.value_type)
    elif isinstance(value, list) and hasattr(kind, "item_type"):
        for index, part in enumerate(value):
            _check_keys(f"{place}[{index}]", part, kind.item_type)


def check_keys(table: Iterable[str], known: Collection[str]) -> None:
    """See that a table has no other keys than these. Raises MalformedError for the first one."""
    for key in table:
        if key not in known:
            raise MalformedError(f": unknown key {quote(key)}{nearest(key, known)}")


def _may_have_long_number(text: str) -> bool:
    """Whether there are more digits in a row than a whole number may have; they may also be part of a text.

    A regular expression would take five times as long as reading the file.
    """
    digits, run = text.encode("utf-8", "surrogatepass").translate(_ZEROS), b"0" * (MAX_DIGITS + 1)
    place = digits.find(run)
    while place >= 0:
        before = digits[place - 1 : place]
        if not (before.isalnum() or before == b"."):  # after a point they are decimals
            return True
        place = digits.find(run, place + len(run))
    return False


def from_toml(text: str) -> dict[str, object]:
    """The tables of a TOML file.

    Raises:
        MalformedError: the text is not TOML, is nested too deeply, or has a number that is too large.
    """
    import tomllib

    if deep := _DEEP_KEY.search(text):
        where = _place(text, deep.start())
        raise MalformedError(f"{where}: nested too deeply; expected a depth of at most {MAX_DEPTH}")
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        place = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
        where = f":{place[1]}:{place[2]}" if place else f":{max(1, len(text.splitlines()))}:1"
        raise MalformedError(f"{where}: not TOML: {str(error).partition(' (at')[0]}") from None
    except (RecursionError, ValueError) as error:  # ValueError: a number of thousands of digits, or no such day
        raise MalformedError(_limit_fault(text) or f": not TOML: {error}") from None
    check_plain(tables)
    return tables


def read_toml(path: Path, kind: type[T]) -> T:
    """A value of this type from a TOML file.

    Raises:
        InputError: located: there is no such file, it is not TOML, or it has other keys or values than the type.
    """
    import msgspec

    try:
        tables = from_toml(read_text(path, MAX_TOML_BYTES))
        check_keys_of(kind, tables)  # its errors name the nearest key
        return msgspec.convert(tables, kind)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except MalformedError as error:
        raise InputError(f"{path}{error}") from None
    except msgspec.ValidationError as error:
        raise InputError(f"{path}: {error}") from None


def from_cache(cache: Any | None, key: str) -> Any:
    """An entry of pytest's cache; None if it is missing or unreadable, so that it is made again.

    Args:
        cache: `config.cache`, or None if the cache plugin is off.
        key: as of `Cache.get`.
    """
    try:
        value = None if cache is None else cache.get(key, None)
        check_plain(value)
    except (RecursionError, MalformedError):  # the cache itself catches what is no JSON
        return None
    return value


def check_plain(value: object) -> None:
    """Check data that no schema describes.

    Raises:
        MalformedError: it is nested too deeply, or a number is not finite or too large.
    """
    places: list[tuple[str, int, object]] = [("$", 0, value)]
    while places:
        place, depth, part = places.pop()
        if depth > MAX_DEPTH:
            raise MalformedError(f": nested too deeply; expected a depth of at most {MAX_DEPTH} - at `{place[:40]}...`")
        if isinstance(part, float) and not math.isfinite(part):
            raise MalformedError(f": expected a finite number, got {part} - at `{place}`")
        if isinstance(part, int) and abs(part) >= 10**MAX_DIGITS:
            raise MalformedError(f": expected at most {MAX_DIGITS} digits, got {quote(part)} - at `{place}`")
        places += [(f"{place}{name}", depth + 1, item) for name, item in _items(part)]


def _items(value: object) -> Iterator[tuple[str, object]]:
    if isinstance(value, dict):
        yield from ((f".{key}", item) for key, item in value.items())
    elif isinstance(value, list):
        yield from ((f"[{index}]", item) for index, item in enumerate(value))


def _json_fault(text: str) -> str:
    """Line and column of what is not JSON: the standard decoder names them, msgspec's does not."""
    import json

    try:
        json.loads(text, parse_int=str, parse_float=str)
    except json.JSONDecodeError as error:
        return f":{error.lineno}:{error.colno}: not JSON, perhaps cut off ({error.msg})"
    except RecursionError:
        pass
    return _limit_fault(text)


def _limit_fault(text: str) -> str:
    """Line and column of the first bracket that is nested too deeply, or number that is too large; else empty."""
    depth = 0
    for part in _PARTS.finditer(text):
        depth += (part.lastgroup == "open") - (part.lastgroup == "close")
        if depth > MAX_DEPTH:
            return f"{_place(text, part.start())}: nested too deeply; expected a depth of at most {MAX_DEPTH}"
        if part.lastgroup == "word":
            return f"{_place(text, part.start())}: expected a finite number, got {part[0]}"
        if part.lastgroup == "number" and (digits := len(part[0].lstrip("+-").replace("_", ""))) > MAX_DIGITS:
            place = _place(text, part.start())
            return f"{place}: expected a number of at most {MAX_DIGITS} digits, got one of {digits}"
    return ""


def _place(text: str, index: int) -> str:
    return f":{text.count(chr(10), 0, index) + 1}:{index - text.rfind(chr(10), 0, index)}"
