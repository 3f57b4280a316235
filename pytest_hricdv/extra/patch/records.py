"""`Patch`: the record of patch coverage in `report.json`: changed statements, and how tests execute them.

`PatchFeature` makes it with `measure`; `PatchView` shows it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, cast

from msgspec import Struct

from pytest_hricdv._base.record import Count, Names, Percent, PlainRecord
from pytest_hricdv.coverage.code_map import Bits, CodeMap, percent
from pytest_hricdv.coverage.records import ArcRecord
from pytest_hricdv.results.section import Section, Share

if TYPE_CHECKING:
    from pytest_hricdv.results.model import Report, TestResult


class FilePatch(PlainRecord, frozen=True, kw_only=True):
    """The changed statements of a file, those that no test executes, and branches from changed ones that none takes."""

    file: str
    statements: tuple[Count, ...]
    missing_lines: tuple[Count, ...] = ()
    missing_branches: tuple[ArcRecord, ...] = ()


class Patch(PlainRecord, frozen=True, kw_only=True):
    """The changes in the code under test, and the tests' coverage of them. Waived statements are left out.

    Args:
        revision: as it was given.
        base: the commit that was compared with.
        files: the files that have changed statements.
        percent: percentage of the changed statements that are executed; 100 if none changed. None if code was not
            measured.
        tests: how many execute a changed statement.
        failed: how many of these fail, known violations aside.
        violated: requirements that they violate.
    """

    revision: str
    base: str
    files: tuple[FilePatch, ...]
    percent: Percent | None = None
    tests: Count = 0
    failed: Count = 0
    violated: Names = ()

    @property
    def by_file(self) -> dict[str, tuple[int, ...]]:
        """File -> its changed statements."""
        return {file.file: file.statements for file in self.files}

    @property
    def statements(self) -> int:
        """Number of changed statements."""
        return sum(len(file.statements) for file in self.files)

    @property
    def hits(self) -> int:
        """Number of changed statements that a test executes."""
        return self.statements - sum(len(file.missing_lines) for file in self.files)


def measure(report: Report, revision: str, base: str, changed: Mapping[str, Iterable[int]], suite: str = "") -> Patch:
    """Measure how a report's tests cover changed statements.

    Args:
        report: the report, with the map of the code.
        revision: the revision that was compared with.
        base: its commit.
        changed: file, as the report names it -> first lines of statements.
        suite: the suite of the tests; empty for all.
    """
    tests = [test for test in report.tests if suite in ("", test.suite)]
    waived = {(waiver.file, waiver.line) for waiver in report.code_under_test.waivers}
    lines = {file: {line for line in of_file if (file, line) not in waived} for file, of_file in changed.items()}
    code = CodeMap.of(report.code_under_test)
    if code is None or not report.code_under_test.measured:
        files = [FilePatch(file=file, statements=tuple(sorted(of_file))) for file, of_file in lines.items()]
        return Patch(revision=revision, base=base, files=tuple(file for file in files if file.statements))
    asked = code.bits({str(file.path): lines.get(file.name, ()) for file in code.files}, None).statements
    reached = [test for test in tests if _bits(test).statements & asked]
    failed = [test for test in reached if test.fails]
    all_bits = reduce(or_, map(_bits, tests), Bits())
    return Patch(
        revision=revision,
        base=base,
        files=tuple(_files(code, lines, all_bits)),
        percent=percent((all_bits.statements & asked).bit_count(), asked.bit_count()),
        tests=len(reached),
        failed=len(failed),
        violated=tuple(name for name in report.requirements if any(test.violates(name) for test in failed)),
    )


def _files(code: CodeMap, lines: Mapping[str, set[int]], bits: Bits) -> Iterable[FilePatch]:
    waived = code.waiver_bits()
    branches = None if bits.branches is None else bits.branches | (waived.branches or 0)
    for file, missing, arcs in code.list_misses(Bits(bits.statements, branches)):
        if mine := lines.get(file.name):
            yield FilePatch(
                file=file.name,
                statements=tuple(line for line in file.statements if line in mine),
                missing_lines=tuple(line for line in missing if line in mine),
                missing_branches=tuple(arc for arc in arcs if arc[0] in mine and arc[0] not in missing),
            )


def _bits(test: TestResult) -> Bits:
    return Bits.of(test.code) or Bits()


PATCH: Section[Patch | None] = Section("patch", Patch | None, None)
"""The patch of a session with --hri-patch."""

SECTIONS = (PATCH,)


def _percent(report: Struct, suite: str) -> float | None:
    patch = PATCH.of(report)
    if patch is None or patch.percent is None:
        return None
    return measure(cast("Report", report), patch.revision, patch.base, patch.by_file, suite).percent


SHARES = (Share("patch", _percent, lambda report: PATCH.of(report) is not None),)
"""The changed statements that a suite's tests execute."""
