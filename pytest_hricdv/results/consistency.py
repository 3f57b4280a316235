"""Checks whether the parts of a report agree. A report that is read may have been edited or truncated."""

from __future__ import annotations

import datetime
import re
from collections.abc import Iterable, Iterator

from pytest_hricdv._base.input_file import MalformedError
from pytest_hricdv._base.message import quote
from pytest_hricdv.coverage.code_map import CoverageError
from pytest_hricdv.coverage.cross_product import CrossProduct
from pytest_hricdv.results.model import Report, TestResult

_CODE_FILE = re.compile(r"(?!(?:.*/)?\.\./)[^\x00-\x1f\x7f]+\.(?:pyw?|pyc|pyd|so)\Z")
"""The name of a file of Python. Other tools read the files that exported coverage names, and show what is in them."""


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
