"""The report of a session from what it declared and the results of its tests: at its end, or later from its journal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from zlib import decompress  # as now: the code under test may replace them

from msgspec.structs import replace

from pytest_hricdv._base.input_file import from_json
from pytest_hricdv.coverage.code_map import CoverageError
from pytest_hricdv.coverage.records import ReportedCode
from pytest_hricdv.results.consistency import check_report
from pytest_hricdv.results.derivation import derive
from pytest_hricdv.results.journal import Journal
from pytest_hricdv.results.model import Report, TestResult


def assemble(
    declared: Report, results: Sequence[TestResult], reasons: Mapping[str, str], wall_s: float
) -> tuple[Report, str]:
    """The report of a session.

    Args:
        declared: the report with all tests that were selected, none of them run.
        results: of the tests that were reported.
        reasons: node id -> why it has no result, where that is known.
        wall_s: how long the session took.

    Returns:
        The report, and what is wrong with it: where a waived statement ran it is without the code's coverage.
    """
    reported = {result.nodeid for result in results}
    not_run = (
        replace(test, failure=reasons.get(test.nodeid, "")) for test in declared.tests if test.nodeid not in reported
    )
    code = declared.code_under_test
    unmeasured = min((result.unmeasured for result in results if result.unmeasured), default=code.reason)
    report = replace(
        declared,
        wall_s=round(wall_s, 3),
        code_under_test=replace(code, reason=unmeasured),
        tests=(*results, *not_run),
    )
    try:
        return derive(report), ""
    except CoverageError as error:
        nothing = ReportedCode(
            packages=code.packages, sha256="", waivers=(), map=(), measured=False, reason=str(error), files=()
        )
        return derive(replace(report, code_under_test=nothing)), str(error)


def rebuild(journal: Journal) -> tuple[Report, str]:
    """The report of what a journal has, and what is wrong with it; see `assemble`.

    Raises:
        ValueError: no test had begun, another version wrote it, or the parts contradict each other.
    """
    declared, results = content(journal)
    return assemble(declared, results, journal.reasons, journal.wall_s)


def content(journal: Journal) -> tuple[Report, list[TestResult]]:
    """The report without results, and the results, of a journal that anybody may have written. Raises as `rebuild`."""
    if journal.declared is None:
        raise ValueError("no test had begun")
    declared = from_json(str(journal.declared, "utf-8"), Report)
    results = [from_json(str(decompress(packed), "utf-8"), TestResult) for packed in journal.results.values()]
    check_report(replace(declared, tests=tuple(results)))
    return declared, results
