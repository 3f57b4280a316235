"""Reports and results as JSON: `encode` and `decode` for a test's result, `canonical` and `load` for `report.json`.

Processes of a session send results as such text; `report.files`, the commands of `hricdv report` and features read
reports. A report may have been edited or truncated, so `check_report` checks that its parts agree.
"""

from __future__ import annotations

import datetime
import math
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import msgspec

from pytest_hricdv._base import own_json as json
from pytest_hricdv._base.contained import file_inside
from pytest_hricdv._base.input_file import MAX_REPORT_BYTES, MalformedError, from_json, read_text
from pytest_hricdv._base.message import InputError, cut, quote
from pytest_hricdv.coverage.code_map import CoverageError
from pytest_hricdv.coverage.cross_product import CrossProduct
from pytest_hricdv.results import journal
from pytest_hricdv.results.model import SCHEMA, Report, TestResult

_CODE_FILE = re.compile(r"(?!(?:.*/)?\.\./)[^\x00-\x1f\x7f]+\.(?:pyw?|pyc|pyd|so)\Z")
"""The allowed names of Python files in a report: other tools read the files that exported coverage names."""


def check_report(report: Report) -> None:
    """Check what the types of the records do not say.

    Raises:
        MalformedError: a part names another one that is not there, one is there twice, or a number is out of range;
            the message is to follow the file's name.
    """
    for place, problem in _problems(report):
        raise MalformedError(f": {problem} - at `$.{place}`")


def check_counts(report: Report) -> None:
    """Check that a report which is complete has as many tests as it says.

    Raises:
        MalformedError: as of `check_report`.
    """
    not_run = sum(test.outcome == "not-run" for test in report.tests)
    counts = {"selected": len(report.tests), "reported": len(report.tests) - not_run, "not_run": not_run}
    for name, count in counts.items():
        if getattr(report, name) != count:
            raise MalformedError(f": expected {count}, as there are tests, got {getattr(report, name)} - at `$.{name}`")


def _problems(report: Report) -> Iterator[tuple[str, str]]:
    yield from _duplicates("suites", "name", (suite.name for suite in report.suites))
    yield from _duplicates("tests", "nodeid", (test.nodeid for test in report.tests))
    yield from _duplicates("code_under_test.map", "file", (file.file for file in report.code_under_test.map))
    yield from _bad_files(report)
    yield from _bad_shards(report)
    yield from _bad_days(report)
    yield from _bad_waivers(report)
    yield from _bad_products(report)
    statements = sum(len(file.statements) for file in report.code_under_test.map)
    branches = sum(len(file.branches) for file in report.code_under_test.map)
    suites = {suite.name for suite in report.suites}
    for number, test in enumerate(report.tests):
        if test.suite not in suites:
            yield f"tests[{number}].suite", f"expected one of the report's suites, got {quote(test.suite)}"
        for again, run in enumerate(test.runs):
            place = f"tests[{number}]" if not again else f"tests[{number}].repeats[{again - 1}]"
            yield from _bad_run(place, report, run, (statements, branches))


def _duplicates(place: str, key: str, names: Iterable[str]) -> Iterator[tuple[str, str]]:
    seen: set[str] = set()
    for number, name in enumerate(names):
        if name in seen:
            yield f"{place}[{number}].{key}", f"expected each once, got {quote(name)} again"
        seen.add(name)


def _bad_files(report: Report) -> Iterator[tuple[str, str]]:
    for number, file in enumerate(report.code_under_test.map):
        if not _CODE_FILE.match(file.file):
            place = f"code_under_test.map[{number}].file"
            yield place, f"expected a file of Python, without steps upwards, got {quote(file.file)}"


def _bad_shards(report: Report) -> Iterator[tuple[str, str]]:
    shards = {f"sessions[{number}].shard": session.shard for number, session in enumerate(report.sessions)}
    for place, shard in {"shard": report.shard, **shards}.items():
        index, _, of = shard.partition("/")
        if shard and int(index) > int(of):
            yield place, f"expected INDEX/OF with INDEX from 1 to OF, got {quote(shard)}"


def _bad_days(report: Report) -> Iterator[tuple[str, str]]:
    days = {f"known_until.{name}": day for name, day in report.known_until.items()}
    exemptions = report.allowed_untriggered.items()
    days |= {f"allowed_untriggered.{name}.until": exemption.until for name, exemption in exemptions if exemption.until}
    for place, day in days.items():
        try:
            datetime.date.fromisoformat(day)
        except ValueError:
            yield place, f"expected a day, YYYY-MM-DD, got {quote(day)}"


def _bad_waivers(report: Report) -> Iterator[tuple[str, str]]:
    statements = {file.file: set(file.statements) for file in report.code_under_test.map}
    for number, waiver in enumerate(report.code_under_test.waivers):
        if statements and waiver.line not in statements.get(waiver.file, ()):
            place = f"{quote(waiver.file)}, line {waiver.line}"
            yield f"code_under_test.waivers[{number}]", f"expected a statement of the code under test, got {place}"


def _bad_products(report: Report) -> Iterator[tuple[str, str]]:
    for name, product in report.cross_products.items():
        place = f"cross_products.{name}"
        try:
            CrossProduct({coordinate.name: coordinate.bins for coordinate in product.coordinates})
        except CoverageError as error:
            yield place, str(error)
        yield from _duplicates(f"{place}.coordinates", "name", (coordinate.name for coordinate in product.coordinates))
        for bin_ in [*(record.bin for record in product.impossible), *(record.bin for record in product.illegal)]:
            yield from _bad_bin(place, report, name, bin_)


def _bad_bin(place: str, report: Report, product: str, bin_: tuple[str, ...]) -> Iterator[tuple[str, str]]:
    coordinates = report.cross_products[product].coordinates
    fits = len(bin_) == len(coordinates) and all(
        part in coordinate.bins for part, coordinate in zip(bin_, coordinates, strict=True)
    )
    if not fits:
        yield place, f"expected a bin of the cross product, a part for each coordinate, got {quote(bin_)}"


def _bad_run(place: str, report: Report, run: TestResult, sizes: tuple[int, int]) -> Iterator[tuple[str, str]]:
    wanted, judged = report.requirements.keys(), run.requirements.keys()
    if strange := judged - wanted:
        yield f"{place}.requirements", f"expected the report's requirements, got {quote(min(strange))}"
    if run.outcome != "not-run" and (missing := wanted - judged):
        yield f"{place}.requirements", f"expected a verdict on each requirement, got none on {quote(min(missing))}"
    if run.outcome == "passed" and run.went_wrong:
        yield f"{place}.outcome", "expected none that passes: the run violates a requirement, or has a fault"
    unknown = [name for name in sorted(judged) if run.violates(name) and name not in report.known_violations]
    if run.outcome == "known-violation" and unknown:
        yield f"{place}.outcome", f"expected none that is known, as no known violation is of {quote(unknown[0])}"
    for product, bins in (run.cross or {}).items():
        if product not in report.cross_products:
            yield f"{place}.cross", f"expected the report's cross products, got {quote(product)}"
        else:
            for bin_ in bins:
                yield from _bad_bin(f"{place}.cross", report, product, bin_)
    if run.code is not None and report.code_under_test.map:
        for bits, size, kind in zip(run.code.bits, sizes, ("statements", "branches"), strict=True):
            if bits is not None and int(bits, 16) >> size:
                yield f"{place}.code.bits", f"expected bits of the {size} {kind} of the code under test, got more"


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
    """Like `encode`, with the texts of the code under test cut; its messages and signals are cut in the timeline."""
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
