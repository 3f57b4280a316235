"""Reports and results as JSON: one encoder, one decoder, and the canonical text of `report.json`."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from pytest_hricdv.results.model import SCHEMA, Report, TestResult

REPORT_NAME = "report.json"

T = TypeVar("T")


class ReportError(Exception):
    """A report cannot be written or read; the message says which file, why, and what to do."""


class MalformedError(ValueError):
    """The text of a file is not what it should be.

    The message is to follow the file's name: `:3:7: not JSON ...`, or `: Expected ... - at $.tests[3].outcome`.
    """


class _Head(msgspec.Struct):
    schema: Any = None


def encode(result: msgspec.Struct) -> str:
    """A result, or another record, as JSON text, for another process."""
    try:
        return msgspec.json.encode(result, enc_hook=_exact).decode()
    except UnicodeEncodeError:  # a lone surrogate, which has no UTF-8: show its number rather than lose the result
        text = json.dumps(msgspec.to_builtins(result, enc_hook=_exact), ensure_ascii=False)
        return re.sub("[\ud800-\udfff]", lambda match: f"\\\\u{ord(match[0]):04x}", text)


def _exact(value: object) -> object:
    """A value of a subclass of JSON's types, such as numpy's float or a StrEnum, as the type itself."""
    if isinstance(value, str):
        return str.__str__(value)
    if isinstance(value, float):
        return float(value)
    if isinstance(value, int):
        return int(value)
    raise NotImplementedError  # msgspec then says that the type is not supported


def decode(text: str | bytes) -> TestResult:
    """The result that `encode` wrote. Raises msgspec.DecodeError for other text."""
    return msgspec.json.decode(text, type=TestResult)


def canonical(record: object) -> str:
    """A record as JSON text that depends on its content only: sorted keys, ASCII, a line for each key and, of lists,
    for each item. (With a line for each value, thousands of tests would take five times as long.)

    Raises:
        ReportError: a value has no JSON, such as NaN or a set.
    """
    try:
        plain = msgspec.to_builtins(record, enc_hook=_exact)
        lines = [f"{_compact(key)}: {_itemized(plain[key])}" for key in sorted(plain)]
    except (TypeError, ValueError) as error:
        place = next(_not_finite(plain, "$"), "") if isinstance(error, ValueError) else ""
        raise ReportError(f"cannot write {place or 'the report'} as JSON: {error}") from error
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _itemized(value: object) -> str:
    if not isinstance(value, list | tuple) or not value:
        return _compact(value)
    return "[\n" + ",\n".join(map(_compact, value)) + "\n]"


def _compact(value: object) -> str:
    return json.dumps(value, sort_keys=True, allow_nan=False)


def _not_finite(value: object, place: str) -> Iterator[str]:
    """Where a number is infinite or none."""
    if isinstance(value, float) and not math.isfinite(value):
        yield place
    elif isinstance(value, dict):
        for key, item in value.items():
            yield from _not_finite(item, f"{place}.{key}")
    elif isinstance(value, list | tuple):
        for index, item in enumerate(value):
            yield from _not_finite(item, f"{place}[{index}]")


def load(path: Path) -> Report:
    """Read a report: a `report.json`, or the folder that holds one.

    Raises:
        ReportError: with the file and the place in it, where it is missing, cut off, of another schema, or incomplete.
    """
    file = path / REPORT_NAME if path.is_dir() else path
    try:
        text = file.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise ReportError(f"{file}: no such report; a run with --hri-suite writes one") from None
    except (OSError, UnicodeDecodeError) as error:
        raise ReportError(f"{file}: cannot be read: {error}") from error
    try:
        found = decode_located(text, _Head).schema
        if found != SCHEMA:
            raise ReportError(
                f"{file}: expected schema {SCHEMA!r}, found {found!r}; use the plugin's version that wrote it"
            )
        return decode_located(text, Report)
    except MalformedError as error:
        raise ReportError(f"{file}{error}; run the suite again") from None


def decode_located(text: str, kind: type[T]) -> T:
    """A record of this kind from the text of a JSON file.

    Raises:
        MalformedError: the text has no JSON, or another one than `kind` has.
    """
    try:
        return msgspec.json.decode(text, type=kind)
    except msgspec.ValidationError as error:  # also raised for the valid beginning of a text that is no JSON
        raise MalformedError(_syntax_fault(text) or f": {error}") from None
    except RecursionError:
        raise MalformedError(": nested too deeply") from None
    except msgspec.DecodeError as error:
        raise MalformedError(_syntax_fault(text) or f": {error}") from None


def _syntax_fault(text: str) -> str:
    """Line and column of what is no JSON: the standard decoder names them, msgspec's does not."""
    try:
        json.loads(text)
    except json.JSONDecodeError as error:
        return f":{error.lineno}:{error.colno}: not JSON, perhaps cut off ({error.msg})"
    return ""
