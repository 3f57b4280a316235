"""Terminal output of the plugin: the `header` line, for `Preparation`, and the `summary`, for `SummarySection`."""

import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from pytest_hricdv._base.message import visible
from pytest_hricdv.report import behaviour_view, totals
from pytest_hricdv.report.brief_summary import brief_lines, requirement_lines
from pytest_hricdv.report.explanation import describe_replay
from pytest_hricdv.report.files import PAGE_NAME
from pytest_hricdv.report.formatting import (
    LABEL_COLUMNS,
    Line,
    Style,
    fit_path,
    label_lines,
    listing,
    pad,
    plural,
    seconds,
    speedup,
    split_first,
    width,
    wrap,
    wrap_line,
)
from pytest_hricdv.report.suite_figures import suite_figures
from pytest_hricdv.report.view import views
from pytest_hricdv.results.model import ReplayComparison, Report, SuiteResult

# Most coverage gaps that are listed. Chosen: the summary of a suite is about a screen; the report has all.
_MAX_GAPS = 8
_SLOW_FACTOR, _SLOW_S = 5.0, 1.0  # a test is named as slow when it takes this many times the mean, and this long


def header(suites: Sequence[str], seed: int, tests: int | None, testbench: str) -> str:
    """The line in pytest's header: `hri: table-assembly, suite rl, seed 0, 134 tests`.

    Args:
        suites: names of the chosen suites.
        seed: the seed they are generated from.
        tests: how many tests were generated, None if that is not known yet.
        testbench: the name of the testbench.
    """
    word = "suite" if len(suites) == 1 else "suites"
    parts = [testbench, f"{word} {' '.join(suites) or 'none'}", f"seed {seed}"]
    if tests is not None:
        parts.append(plural(tests, "test"))
    return visible(f"hri: {', '.join(parts)}")


def replay_header(testbench: str, files: int) -> str:
    """The line in pytest's header: `hri: table-assembly, replay of 1 test`."""
    return visible(f"hri: {testbench}, replay of {plural(files, 'test')}")


def summary(
    report: Report,
    directory: Path,
    width: int = 80,
    *,
    brief: bool = False,
    notes: Sequence[Line] = (),
    problems: Sequence[str] = (),
) -> tuple[Line, ...]:
    """The report in lines of at most `width` columns, its verdict last.

    Lines with a path or a command may be longer: if cut, they cannot be opened or used.

    Args:
        brief: whether the summary has to fit on a screen: counts, with the first item of each.
        problems: why the session fails besides its tests.
    """
    if brief:
        is_red = totals.has_failed(report) or bool(problems)
        shown = brief_lines(report, width, len(notes) + len(problems), is_red=is_red)
        lines = [*_vacuity_lines(report, width), *shown]
    else:
        lines = [*_vacuity_lines(report, width), *_body(report, width)]
    failed = [Line(visible(f"FAILED {problem}"), "bad") for problem in problems]
    ending = [
        *_fit_lines(_totals(report, width, brief=brief), width),
        *_verdict(report, directory, width, has_problems=bool(problems)),
    ]
    return (*_fit_lines(lines, width), *findings(report), *notes, *failed, *ending)


def _fit_lines(lines: Iterable[Line], columns: int) -> Iterator[Line]:
    for line in lines:
        yield from (Line(text, line.style) for text in wrap_line(visible(line.text), columns))


def _body(report: Report, width: int) -> Iterator[Line]:
    for suite in report.suites:
        yield from (*_suite(report, suite, width), Line(""))
    for part in (
        [*_files(report, width), *_gaps(report, width)],
        behaviour_view.lines(report, width),
        *(view.lines(report, width) for view in views()),
    ):
        if shown := list(part):
            yield from (*shown, Line(""))


def findings(report: Report) -> Iterator[Line]:
    """Faults, replays and what features found, in lines of any width: a command that is cut cannot be used."""
    yield from _faults(report)
    for test in report.tests:
        if test.replayed:
            yield from _replay_lines(test.id, test.replayed)
    for view in views():
        yield from view.findings(report)


def _vacuity_lines(report: Report, columns: int) -> Iterator[Line]:
    """Lines about vacuity. "Nothing was checked" comes first: passed tests look as if all were well."""
    sentences = totals.list_vacuity_warnings(report)
    for sentence in sentences:
        for line in wrap(visible(sentence).split(" "), columns):
            yield Line(line, "bad")
    if sentences:
        yield Line("")


def _suite(report: Report, suite: SuiteResult, columns: int) -> Iterator[Line]:
    simulation = f", {suite.fidelity} simulation" if suite.fidelity else ""
    simulation += f" on {suite.engine}" if suite.engine else ""
    yield Line(f"suite {suite.name}, seed {suite.seed}: {totals.tests_text(report, suite)}{simulation}", "title")
    yield from requirement_lines(report, suite, columns)
    for figure in suite_figures(report, suite):
        yield from label_lines(figure.label, figure.text, columns, figure.style)


def _files(report: Report, columns: int) -> Iterator[Line]:
    """Files of the code under test that nothing imported, and those that were not measured completely."""
    code = report.code_under_test
    if code.never_imported:
        yield from label_lines("never imported", ", ".join(code.never_imported), columns, "warn")
    for file, reason in sorted(code.unmeasured_files.items()):
        yield from label_lines("unmeasured", f"{file}: {reason}", columns, "warn")


def _gaps(report: Report, columns: int) -> Iterator[Line]:
    gaps = totals.gaps(report)
    if not gaps:
        return
    yield Line("not covered", "title")
    labels = [visible(gap.place if gap.kind in ("lines", "branches") else f"{gap.place} {gap.kind}") for gap in gaps]
    room = max(min(max(map(width, labels[:_MAX_GAPS])), columns // 2 - 4), LABEL_COLUMNS)
    above = ""
    for gap, label in zip(gaps[:_MAX_GAPS], labels, strict=False):
        shown = fit_path(label, room) if gap.kind in ("lines", "branches") else label
        if width(shown) > room and label != above:
            yield Line(f"  {shown}")
            above = label
        start = f"  {pad('' if label == above else shown, room)}  "
        start += "branches " if gap.kind == "branches" else ""
        above = label
        yield Line(start + listing([visible(item) for item in gap.items], max(columns - width(start), 12)))
    if len(gaps) > _MAX_GAPS:
        yield Line(f"  ... and {plural(len(gaps) - _MAX_GAPS, 'more place')}: see the report", "dim")


def _totals(report: Report, columns: int, *, brief: bool) -> Iterator[Line]:
    lost = totals.loss(report)
    expected = f"{report.reported}/{report.selected} tests reported"
    if lost or not brief:
        yield Line(f"{expected}: {lost}" if lost else expected, "bad" if lost else "plain")
    names, more = split_first(report.not_run_tests, 3)
    for name in names:
        yield Line(f"  not run: {fit_path(visible(name), columns - 11)}", "bad")
    if more:
        yield Line(f"  not run: and {more} more", "bad")
    if not brief:
        yield from (_duration(report), *_slowest(report))
    for view in views():
        yield from view.file_lines(report, columns)


def _verdict(report: Report, directory: Path, columns: int, *, has_problems: bool) -> Iterator[Line]:
    """`PASSED  120 passed, 14 known to fail    hri-report/index.html`."""
    is_bad = totals.has_failed(report) or has_problems or bool(totals.loss(report))
    passed = totals.outcomes(report)["passed"]
    word = "FAILED" if is_bad else "PASSED" if passed else "NO TEST PASSED"
    noun = next(filter(None, (view.test_noun(report) for view in views())), "")
    selected, whole = (sum(getattr(suite, name) for suite in report.suites) for name in ("tests", "size"))
    noun = noun or (f"{selected} of {plural(whole, 'test')}" if selected < whole else "")
    text = f"{word}  {f'{noun}: ' if noun else ''}{totals.outcomes_text(report)}"
    style: Style = "bad" if is_bad else "ok" if passed else "warn"
    page = directory / PAGE_NAME
    path = visible(str(page.relative_to(Path.cwd()) if page.is_relative_to(Path.cwd()) else page))
    if report.full_report:
        yield Line(visible(f"full report: {directory / report.full_report}"), "dim")
    if width(text) + 4 + width(path) <= columns:
        yield Line(f"{text}    {path}", style)
    else:
        yield from (Line(path, "dim"), *_fit_lines([Line(text, style)], columns))


_TIME = re.compile(r"\b\d+(\.\d+)? s\b")
_NUMBER = re.compile(r"\d+")


def _cause(fault: str) -> str:
    """The common part of equal faults of several tests: all but times, and the numbers of a crash."""
    cause = _TIME.sub("", fault)
    return _NUMBER.sub("", cause) if " raised " in cause else cause


def _faults(report: Report) -> Iterator[Line]:
    alike: dict[str, list[tuple[str, str]]] = {}
    for test in report.tests:
        for fault in test.errors:
            alike.setdefault(_cause(fault), []).append((fault, test.id))
    faults, more = split_first(list(alike.values()), 3)
    for (fault, first), *others in faults:
        tests = f"{first}, and {plural(len(others), 'more test')}" if others else first
        yield Line(visible(f"fault: {fault} ({tests})"), "bad")
    if more:
        yield Line(f"fault: and {more} more", "bad")


def _duration(report: Report) -> Line:
    time = totals.duration(report)
    speed = f": {speedup(time.speed)} real time" if time.speed else ""
    workers = f" with {plural(time.workers, 'worker')}" if time.workers > 1 else ""
    return Line(f"simulated {seconds(time.simulated_s)} in {seconds(time.wall_s)}{workers}{speed}", "dim")


def _slowest(report: Report) -> Iterator[Line]:
    timed = [(test.wall_s, test.id) for test in report.tests if test.wall_s is not None]
    if not timed:
        return
    wall_s, slow = max(timed)
    if wall_s > _SLOW_S and wall_s > _SLOW_FACTOR * sum(time_s for time_s, _ in timed) / len(timed):
        yield Line(f"slowest: {seconds(wall_s)} {slow}", "dim")


def _replay_lines(test: str, replayed: ReplayComparison) -> Iterator[Line]:
    text, hint = describe_replay(replayed)
    yield Line(visible(f"replay of {test}: {text}"), "ok" if replayed.same else "warn" if replayed.changed else "bad")
    if hint:
        yield Line(visible(f"  {hint}"), "warn")
