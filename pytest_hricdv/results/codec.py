"""Reports and results as JSON: one encoder, one decoder, and the canonical text of `report.json`."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec

from pytest_hricdv._base import own_json as json
from pytest_hricdv._base.contained import file_inside
from pytest_hricdv._base.input_file import MAX_REPORT_BYTES, MalformedError, from_json, read_text
from pytest_hricdv._base.message import InputError, cut, quote
from pytest_hricdv.results import journal
from pytest_hricdv.results.consistency import check_counts, check_report
from pytest_hricdv.results.model import SCHEMA, Report, TestResult

REPORT_NAME = "report.json"


class ReportError(InputError):
    """A report cannot be written or read; the message says which file, why, and what to do."""


class _ReportHead(msgspec.Struct):
    schema: str | int | None = None


def encode(result: msgspec.Struct) -> str:
    """A result, or another record, as JSON text, for another process."""
    try:
        return msgspec.json.encode(result, enc_hook=_exact).decode()
    except UnicodeEncodeError:  # a lone surrogate, which has no UTF-8: show its number rather than lose the result
        text = json.dumps(msgspec.to_builtins(result, enc_hook=_exact), ensure_ascii=False)
        return re.sub("[\ud800-\udfff]", lambda match: f"\\\\u{ord(match[0]):04x}", text)


def encode_bounded(result: TestResult) -> str:
    """As `encode`, with the texts of the code under test cut; its messages and signals are cut in the timeline."""
    try:
        text = encode(result)
        if len(text) <= 1_000_000:
            return text
    except MemoryError:
        pass  # once more with less
    timeline = result.timeline
    plain = _cut_texts(msgspec.to_builtins(msgspec.structs.replace(result, timeline=None), enc_hook=_exact))
    return encode(msgspec.structs.replace(msgspec.convert(plain, TestResult), timeline=timeline))


def _cut_texts(value: Any) -> Any:
    """JSON with its texts cut."""
    if isinstance(value, str):
        return cut(value)
    if isinstance(value, dict):
        return {key: _cut_texts(item) for key, item in value.items()}
    return [_cut_texts(item) for item in value] if isinstance(value, list | tuple) else value


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
        lines = [f"{_compact(key)}: {_item_lines(plain[key])}" for key in sorted(plain)]
    except (TypeError, ValueError) as error:
        place = next(_not_finite(plain, "$"), "") if isinstance(error, ValueError) else ""
        raise ReportError(f"cannot write {place or 'the report'} as JSON: {error}") from error
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _item_lines(value: object) -> str:
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
        ReportError: with the file and the place in it, where it is missing, cut off, of another schema, incomplete or
            contradictory;
            or a later session has begun in its folder and has not ended.
    """
    file = path / REPORT_NAME if path.is_dir() else path
    _refuse_unfinished(file)
    try:
        file_inside(file.parent, file.name)  # also where a pattern of the shell named it, as in `merge shards/*/*.json`
        text = read_text(file, MAX_REPORT_BYTES)
        schema = from_json(text, _ReportHead).schema
        if schema != SCHEMA:
            raise ReportError(
                f"{file}: expected schema {SCHEMA!r}, found {quote(schema)}: run the suite again, or read the report "
                "with the version of the plugin that wrote it"
            )
        report = from_json(text, Report)
        check_report(report)
        check_counts(report)
        return report
    except FileNotFoundError:
        raise ReportError(f"{file}: no such report; a run with --hri-suite writes one") from None
    except OSError as error:
        raise ReportError(f"{file}: {error.strerror}") from None
    except MalformedError as error:
        raise ReportError(f"{file}{error}; run the suite again") from None


def _refuse_unfinished(file: Path) -> None:
    """Raise ReportError where the session that writes, or should have written, this report has not ended."""
    path = file.with_name(journal.NAME)
    if file.name != REPORT_NAME or not path.is_file():
        return
    try:
        ended = journal.is_ended(path)
    except OSError as error:
        raise ReportError(f"{path}: cannot be read: {error}") from error
    if not ended:
        raise ReportError(
            f"{file.parent}: the session that writes this report is still running, or its process died; then "
            f"'hricdv report rebuild {file.parent}' makes the report of what had finished, and pytest "
            "with --hri-resume runs the rest"
        )
