"""`hricdv report merge|gate|rebuild|minimal|export|triage`: commands on reports that were written."""

from __future__ import annotations

import argparse
import datetime
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from msgspec import structs

from pytest_hricdv._base.command_line import CommandParser, work_on_unread
from pytest_hricdv._base.message import harmless_line
from pytest_hricdv.generate import GenerateError, chosen_values
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.suite_files import dump_tests
from pytest_hricdv.registry import offers
from pytest_hricdv.report import EXPORT_FORMATS, terminal, totals
from pytest_hricdv.report.carrying import FileCarrier
from pytest_hricdv.report.exports import ExportTargets, write_exports
from pytest_hricdv.report.failing_tests import FailingTests
from pytest_hricdv.report.files import write, write_text
from pytest_hricdv.report.formatting import Line
from pytest_hricdv.report.view import commands_of_features
from pytest_hricdv.results.baseline import (
    Baseline,
    BaselineError,
    baseline_of,
    check_suites,
    read_baseline,
    write_baseline,
)
from pytest_hricdv.results.behaviour_diff import compare_behaviour
from pytest_hricdv.results.codec import REPORT_NAME, ReportError, load
from pytest_hricdv.results.folder_files import FolderLock, LockedError
from pytest_hricdv.results.gate_check import check_gates, gates_of
from pytest_hricdv.results.gates import Threshold, ThresholdError, parse_threshold, threshold_kinds
from pytest_hricdv.results.journal import NAME, EndRecord, Journal, JournalWriter
from pytest_hricdv.results.journal import read as read_journal
from pytest_hricdv.results.merging import MergeError, count_expected, list_missing_shards, merge, sessions_of
from pytest_hricdv.results.model import GateResult, Report, TestResult
from pytest_hricdv.results.report_builder import rebuild

OK, FAILED, USAGE = 0, 1, 2


def main(arguments: Sequence[str] | None = None, called: str = "hricdv report") -> int:
    """Do what the command line says.

    Returns:
        The exit status: 0 if all is well, 1 if tests or a gate failed or results are missing, 2 where a report
        cannot be used.
    """
    options = _parser(called).parse_args(arguments)
    try:
        return int(options.do(options))
    except (ReportError, MergeError, BaselineError) as error:
        print(f"error: {error}", file=sys.stderr)
        return USAGE


def _parser(called: str) -> CommandParser:
    parser = CommandParser(prog=called, description=__doc__)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    merging = commands.add_parser("merge", help="merge the reports of shards, suites or repeated runs")
    merging.add_argument("reports", nargs="+", type=Path, metavar="REPORT", help="a report folder or its report.json")
    merging.add_argument("-o", "--output", type=Path, default=Path("hri-merged"), help="folder (default hri-merged)")
    merging.set_defaults(do=_merge)
    gating = commands.add_parser("gate", help="check a report against gates; exit 1 where one fails")
    gating.add_argument("report", type=Path, metavar="REPORT")
    gating.set_defaults(do=_gate)
    rebuilding = commands.add_parser("rebuild", help="make the report of a session that was killed from its journal")
    rebuilding.add_argument("folder", type=Path, metavar="DIR", help="the folder of the report")
    rebuilding.set_defaults(do=_rebuild)
    minimal = commands.add_parser("minimal", help="write the smallest suite that covers as much as the report's tests")
    minimal.add_argument("report", type=Path, metavar="REPORT")
    minimal.add_argument("folder", type=Path, metavar="DIR", help="for --hri-suite=DIR")
    minimal.set_defaults(do=_minimal)
    for parser_of_gates in (merging, gating):
        _add_gates(parser_of_gates)
    exporting = commands.add_parser("export", help="write files for other tools from a report")
    exporting.add_argument("report", type=Path, metavar="REPORT")
    for name, purpose in EXPORT_FORMATS.items():
        exporting.add_argument(f"--{name}", type=Path, metavar="FILE", help=purpose)
    exporting.add_argument("--root", default=".", help="the folder that file names are relative to (default .)")
    exporting.set_defaults(do=_export)
    for command in commands_of_features():
        parser_of_part = commands.add_parser(command.name, help=command.purpose)
        command.add_arguments(parser_of_part)
        parser_of_part.set_defaults(do=command.do)
    return parser


def _add_gates(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add(
        "--fail-under",
        action="append",
        type=_threshold,
        default=[],
        metavar="KIND=PCT",
        help=f"KIND: {', '.join(threshold_kinds())}",
    )
    add(
        "--fail-on-nc",
        action="store_true",
        help="fail when no test triggered a requirement; reports of whole suites always do",
    )
    add(
        "--allow-nc",
        action="append",
        default=[],
        metavar="REQUIREMENT",
        help="a requirement that need not be triggered; repeatable",
    )
    add(
        "--fail-on-pending",
        action="store_true",
        help="fail when a requirement was triggered and is undecided at the end of a run",
    )
    add("--baseline", type=Path, metavar="FILE", help="new failures, lost coverage and lost triggers fail")
    add("--update-baseline", action="store_true", help="update the file of --baseline")
    add("--fail-on-change", action="store_true", help="fail when a test behaves differently from the baseline")


def rebuild_report(folder: Path) -> tuple[Report, str]:
    """Write the report of what the journal in a report folder has; returns it, and what is wrong with it.

    It has neither gates nor what follows the tests (the audit, a search, mutants): these need the whole session, and
    its problems name what is missing. Features add what the journal has kept of their work.

    Raises:
        ReportError: there is no journal, its session is running, ended with a report, or had begun no test; or the
            folder cannot be written.
    """
    path = folder / NAME
    if not path.is_file():
        raise ReportError(f"{path}: no such journal; a run with --hri-suite writes one")
    try:
        lock = FolderLock(folder)
    except LockedError as error:
        raise ReportError(f"{folder}: its session is still running ({error}): wait for its end") from None
    except OSError as error:
        raise ReportError(f"{folder}: cannot be written: {error.strerror or error}") from error
    try:
        return _rebuild_unlocked(folder, path, read_journal(path))
    except OSError as error:
        raise ReportError(f"{path}: cannot be read: {error.strerror or error}") from error
    finally:
        lock.release()


def _rebuild_unlocked(folder: Path, path: Path, journal: Journal) -> tuple[Report, str]:
    if journal.is_ended and (folder / REPORT_NAME).is_file():
        raise ReportError(f"{folder}: the session ended, and {REPORT_NAME} has all its results: nothing to rebuild")
    try:
        report, problem = rebuild(journal)
    except ValueError as error:
        raise ReportError(f"{path}: no report can be made of it: {error}; run the suite again") from None
    for of_part in offers("merging", "rebuilt"):
        report = of_part(report, journal.kept)
    write(report, folder)
    writer = JournalWriter(path, journal.size)
    writer.append(EndRecord(journal.wall_s - journal.earlier_s))
    writer.close()
    return report, problem


def minimal_tests(report: Report) -> list[AbstractTest]:
    """The minimal suite of a report as abstract tests, in the order of their ids, each once.

    Raises:
        ReportError: a test of the report cannot be written as text.
    """
    wanted = {step.nodeid for step in report.closure.minimal}
    chosen = {test.id: test for test in report.tests if test.nodeid in wanted}
    try:
        return [_abstract_test(chosen[name]) for name in sorted(chosen)]
    except GenerateError as error:
        raise ReportError(f"the report's tests cannot be written: {error}") from None


def _abstract_test(test: TestResult) -> AbstractTest:
    return AbstractTest(
        id=test.id,
        suite=test.suite,
        target=test.target or "minimal",
        beliefs=test.beliefs,
        lines=test.abstract,
        plans=test.plans,
        seed=test.seed,
        name=test.name,
        values=chosen_values.from_data(test.values),
    )


def _threshold(text: str) -> Threshold:
    try:
        return parse_threshold(text)
    except ThresholdError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def _merge(options: argparse.Namespace) -> int:
    folders = [path if path.is_dir() else path.parent for path in options.reports]
    carrying = FileCarrier(folders, options.output)
    # Sessions are noted before files are renamed: their hashes do not depend on where a report lies.
    loaded = (structs.replace(report, sessions=sessions_of(report)) for report in map(load, options.reports))
    reports = [
        (str(path), carrying.rename_files(report, folder))
        for path, folder, report in zip(options.reports, folders, loaded, strict=True)
    ]
    merged, checked = _judge(merge(reports), options)
    merged = structs.replace(merged, gates=checked)
    carrying.copy()
    write(merged, options.output)
    print(f"{options.output}: merged from {len(reports)} reports of {len(merged.sessions)} runs")
    return _print_report(merged, checked, options.output)


def _gate(options: argparse.Namespace) -> int:
    folder = options.report if options.report.is_dir() else options.report.parent
    report = load(options.report)
    if not report.tests:
        raise ReportError(
            f"{options.report}: has no tests, so there is nothing to judge; expected a session that ran some"
        )
    return _print_report(*_judge(report, options), folder)


def _rebuild(options: argparse.Namespace) -> int:
    report, problem = rebuild_report(options.folder)
    print(f"{options.folder}: rebuilt with the {report.reported} of {report.selected} tests that have a result")
    failed = [*([problem] if problem else []), *report.problems]
    if report.not_run:
        failed.append(f"{report.not_run} of {report.selected} tests have no result: totals are lower bounds")
    failed += [f"{test.id}: {test.outcome}" for test in report.tests if test.fails]
    return _print_failures(failed)


def _export(options: argparse.Namespace) -> int:
    targets = ExportTargets.of({name: getattr(options, name) for name in EXPORT_FORMATS})
    if not any(getattr(options, name) for name in EXPORT_FORMATS) and targets.job_summary is None:
        raise ReportError(f"export: say what to write, with {', '.join(f'--{name}=FILE' for name in EXPORT_FORMATS)}")
    written = write_exports(load(options.report), targets, options.root)
    for text in written.notes:
        print(harmless_line(text))
    return _print_failures(written.problems)


def _minimal(options: argparse.Namespace) -> int:
    report = load(options.report)
    tests = minimal_tests(report)
    for suite in sorted({test.suite for test in tests}):
        mine = [test for test in tests if test.suite == suite]
        path = write_text(options.folder / f"{suite}.txt", dump_tests(mine))
        print(f"{path}: {len(mine)} tests")
    closure, steps = report.closure, report.closure.minimal
    print(
        f"{len(steps)} of {report.selected} tests cover all {closure.points} points in "
        f"{steps[-1].sim_s if steps else 0:.0f} of {closure.sim_s:.0f} simulated s"
    )
    return OK


def _print_failures(texts: Sequence[str]) -> int:
    """Print what failed; returns the exit status."""
    for text in texts:
        print(harmless_line(f"FAILED {text}"))
    return FAILED if texts else OK


def _print_report(report: Report, checked: GateResult, folder: Path) -> int:
    """Says what a session says at its end."""
    columns = shutil.get_terminal_size().columns
    failing = FailingTests.of(report, columns)
    print(f"{report.reported}/{count_expected(report)} tests merged")
    failed = [f"{test.id}: {test.outcome}" for test in report.tests if test.fails and failing.causes is None]
    notes = [Line(text) for text in checked.improved]
    problems = [*failed, *checked.failed]
    summary = terminal.summary(report, folder, columns, brief=True, notes=notes, problems=problems)
    for line in (*failing.list_causes(columns), *summary):
        print(harmless_line(line.text))
    return FAILED if problems or totals.has_failed(report) else OK


def _judge(report: Report, options: argparse.Namespace) -> tuple[Report, GateResult]:
    """Check a report against all gates, and compare it; write the baseline where that was asked for."""
    missing = count_expected(report) - report.reported
    failed = [f"shard {shard} is missing" for shard in list_missing_shards(report)]
    if missing > 0:
        failed.append(f"{missing} of {count_expected(report)} tests have no result: totals are lower bounds")
    failed += report.problems
    old = _baseline(report, options)
    compared = None if options.update_baseline else old
    if compared is not None:
        report = structs.replace(report, changes=compare_behaviour(report, compared, whole=True))
    allowed = [name for names in options.allow_nc for name in names.split(",")]
    gates = gates_of(
        report,
        thresholds=options.fail_under,
        fail_on_nc=options.fail_on_nc,
        allowed=allowed,
        fail_on_change=options.fail_on_change,
        fail_on_pending=options.fail_on_pending,
    )
    checked = check_gates(report, gates, compared, datetime.datetime.now(datetime.UTC).date(), whole=True)
    if options.update_baseline and missing > 0:
        failed.append(f"{options.baseline} was not updated: tests are missing")
    elif options.update_baseline:
        write_baseline(baseline_of(report, old), options.baseline)
    return report, structs.replace(checked, failed=(*failed, *checked.failed))


def _baseline(report: Report, options: argparse.Namespace) -> Baseline | None:
    if options.update_baseline and options.baseline is None:
        raise BaselineError("--update-baseline: say which file, with --baseline=FILE")
    if options.fail_on_change and options.baseline is None:
        raise BaselineError("--fail-on-change: compared with what? give --baseline=FILE")
    if options.baseline is None or (options.update_baseline and not options.baseline.exists()):
        return None
    baseline = read_baseline(options.baseline, report.testbench)
    if not options.update_baseline:
        seeds = {suite.name: suite.seed for suite in report.suites}
        check_suites(baseline, seeds, str(options.baseline), behaviour=options.fail_on_change)
    return baseline


if __name__ == "__main__":
    work_on_unread()
    sys.exit(main(sys.argv[1:]))
