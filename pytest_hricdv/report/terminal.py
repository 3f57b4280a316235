"""What a run prints: the line in pytest's header, a failing test's text, the section at the end."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from pytest_hricdv.report import totals
from pytest_hricdv.report.explanation import aborted, failure
from pytest_hricdv.report.figure import percent, plural, seconds, share
from pytest_hricdv.report.files import PAGE_NAME
from pytest_hricdv.report.line import Line, Style, fit, listing, more, pad, visible, width, wrap

__all__ = ["aborted", "failure", "header", "summary"]

_MAX_GAPS = 8
_MAX_NOT_RUN = 3
_LABEL_COLUMNS = 20
_SLOW_FACTOR, _SLOW_S = 5.0, 1.0  # a test is worth a line when it takes this many times the mean, and not a blink


def header(suites: Sequence[str], seed: int, tests: int | None, testbench: str) -> str:
    """The line in pytest's header: `hri: table-assembly, suite rl, seed 0, 134 tests`.

    Args:
        suites: names of the chosen suites.
        seed: the seed they are generated from.
        tests: how many tests were generated, None where that is not known yet.
        testbench: the name of the testbench.
    """
    word = "suite" if len(suites) == 1 else "suites"
    parts = [testbench, f"{word} {' '.join(suites) or 'none'}", f"seed {seed}"]
    if tests is not None:
        parts.append(plural(tests, "test"))
    return visible(f"hri: {', '.join(parts)}")


def summary(report: Mapping[str, Any], directory: Path, width: int = 80) -> tuple[Line, ...]:
    """The report in lines of at most `width` columns.

    One line may be longer: where the report is. A path that is cut cannot be opened.
    """
    lines: list[Line] = []
    for suite in report["suites"]:
        lines += [*_suite(report, suite, width), Line("")]
    uncovered = list(_gaps(report, width))
    lines += [*uncovered, Line("")] if uncovered else []
    lines += _totals(report, width)
    fitted = [Line(fit(visible(line.text), width), line.style) for line in lines]
    return (*fitted, Line(visible(f"report: {directory / PAGE_NAME}"), "dim"))


def _suite(report: Mapping[str, Any], suite: Mapping[str, Any], columns: int) -> Iterator[Line]:
    tests = f": {plural(suite['tests'], 'test')}" if "tests" in suite else ""
    fidelity = f", {suite['fidelity']} simulation" if suite.get("fidelity") else ""
    yield Line(f"suite {suite['name']}, seed {suite['seed']}{tests}{fidelity}", "title")
    yield from _requirements(totals.tallies(report, suite), columns)
    for kind in ("statements", "branches"):
        yield from _code(kind, suite["code"][kind], report, columns)
    for agent in sorted(suite["plans"]):
        figures = suite["plans"][agent]
        covered, total = len(figures["covered"]), figures["total"]
        yield from _row(f"plans of {agent}", f"{percent(share(covered, total))} ({covered} of {total})", columns)
    if suite["cross"]["bins"]:
        yield from _row("cross product", _cross(suite["cross"]), columns)
    yield from _generation(suite["generation"], columns)


def _requirements(rows: Sequence[totals.Tally], columns: int) -> Iterator[Line]:
    if not rows:
        yield Line("  no requirements", "dim")
        return
    margins = any(row.margin is not None for row in rows)
    marks = 6 if any(row.failed and row.known for row in rows) else 0
    numbers = 7 + 8 + marks + 6 + 10 + (10 if margins else 0)
    room = max(columns - numbers - 2, 4)
    head = f"{'Passed':>7}{'Failed':>8}{'':{marks}}{'NC':>6}{'triggers':>10}{'margin' if margins else '':>10}"
    yield Line(f"  {pad('requirement', room)}{head}".rstrip(), "dim")
    for row in rows:
        mark = " known" if row.failed and row.known else ""
        margin = "" if row.margin is None else f"{row.margin:.3g}"
        figures = f"{row.passed:>7}{row.failed:>8}{mark:{marks}}{row.nc:>6}{row.triggers:>10}{margin:>10}"
        name = pad(visible(f"{row.name} {row.title}"), room)
        yield Line(f"  {name}{figures}".rstrip(), _verdict_style(row))
    unchecked = [row.name for row in rows if not row.passed + row.failed]
    if unchecked:
        yield from _row("NC: not checked", f"{listing(unchecked, columns // 3)}: no test triggered it", columns, "warn")
    for row in rows:
        if row.failed and row.known:
            yield Line(f"  {row.name} is known to fail: {row.known}", "warn")


def _verdict_style(row: totals.Tally) -> Style:
    if row.failed:
        return "warn" if row.known else "bad"
    return "ok" if row.passed else "dim"


def _code(kind: str, figures: Mapping[str, Any] | None, report: Mapping[str, Any], columns: int) -> Iterator[Line]:
    if figures is None:
        return _row(kind, f"unmeasured: {totals.unmeasured(report)}", columns, "warn")
    covered, total, reachable = figures["covered"], figures["total"], figures["reachable"]
    raw = f"{percent(figures['percent'])} ({covered} of {total})"
    waived = len(totals.waivers(report))
    of = f"{reachable} reachable" + (f", {waived} waived" if waived and kind == "statements" else "")
    text = f"{raw}, {percent(totals.percent_reachable(figures))} of {of}"
    return _row(kind, text, columns)


def _cross(cross: Mapping[str, Any]) -> str:
    possible = cross["bins"] - cross["impossible"] - cross.get("illegal", 0)
    text = f"{percent(share(cross['hit'], possible))} ({cross['hit']} of {plural(possible, 'bin')})"
    return f"{text}, {cross['impossible']} impossible" if cross["impossible"] else text


def _generation(generation: Mapping[str, Any], columns: int) -> Iterator[Line]:
    parts = []
    if generation["iterations"]:
        at = generation["converged_at"]
        parts.append(plural(generation["iterations"], "iteration"))
        parts.append("not converged" if at is None else f"converged at {at}")
    if generation["bdi_runs"]:
        parts.append(plural(generation["bdi_runs"], "model run"))
    if generation.get("distinct_texts") is not None:
        parts.append(plural(generation["distinct_texts"], "distinct text"))
    parts.append("cached" if generation.get("cached") else seconds(generation["wall_s"]))
    yield from _row("learned in" if generation["iterations"] else "generated in", ", ".join(parts), columns, "dim")
    if found := generation.get("diagnosis"):
        yield from _row("variety", _variety(found), columns, "dim")
    for note in generation.get("notes", ()):
        yield from _row("note", note, columns, "warn")


def _variety(found: Mapping[str, Any]) -> str:
    parts = []
    if found["distinct_subsets"]:
        parts.append(plural(found["distinct_subsets"], "belief set"))
        bits, most = found["belief_entropy_bits"], found["belief_entropy_most_bits"]
        parts.append(f"{bits:.2f} of {most:.2f} bits of beliefs")
    news = found.get("last_new_plan", {})
    ends = [f"{name} {news[name]}" for name in ("iteration", "test") if news.get(name)]
    parts.append("no new plan after " + " and ".join(ends) if ends else "no plans of a model")
    return ", ".join(parts)


def _gaps(report: Mapping[str, Any], columns: int) -> Iterator[Line]:
    gaps = totals.gaps(report)
    if not gaps:
        return
    yield Line("not covered", "title")
    labels = [
        visible(f"{gap.place} {gap.kind}" if gap.kind not in ("lines", "branches") else gap.place) for gap in gaps
    ]
    room = max(min(max(map(width, labels[:_MAX_GAPS])), columns // 2 - 4), _LABEL_COLUMNS)
    above = ""
    for gap, label in zip(gaps[:_MAX_GAPS], labels, strict=False):
        start = f"  {pad('' if label == above else label, room)}  "
        start += "branches " if gap.kind == "branches" else ""
        above = label
        yield Line(start + listing([visible(item) for item in gap.items], max(columns - width(start), 12)))
    if len(gaps) > _MAX_GAPS:
        yield Line(f"  ... and {plural(len(gaps) - _MAX_GAPS, 'more place')}: see the report", "dim")


def _totals(report: Mapping[str, Any], columns: int) -> Iterator[Line]:
    counts = totals.outcomes(report)
    words = {"passed": "passed", "failed": "failed", "known-violation": "known to fail", "error": "in error"}
    told = ", ".join(f"{counts[name]} {word}" for name, word in words.items() if counts[name]) or "nothing run"
    bad = counts["failed"] or counts["error"]
    yield Line(f"tests: {told}", "bad" if bad else "ok" if counts["passed"] else "warn")
    lost = totals.loss(report)
    expected = f"expected {report['selected']}, reported {report['reported']}"
    yield Line(f"{expected}: {lost}" if lost else expected, "bad" if lost else "ok")
    names = report.get("not_run_tests", ())
    for name in names[:_MAX_NOT_RUN]:
        yield Line(f"  not run: {name}", "bad")
    if len(names) > _MAX_NOT_RUN:
        yield Line(f"  not run: {more(len(names) - _MAX_NOT_RUN).removeprefix(', ')}", "bad")
    yield _time(report)
    yield from _slowest(report)
    yield from _films(report, columns)


def _time(report: Mapping[str, Any]) -> Line:
    time = totals.time(report)
    speed = f": {totals.times(time.speed)} real time" if time.speed else ""
    workers = f" with {plural(time.workers, 'worker')}" if time.workers > 1 else ""
    return Line(f"simulated {seconds(time.simulated_s)} in {seconds(time.wall_s)}{workers}{speed}", "dim")


def _slowest(report: Mapping[str, Any]) -> Iterator[Line]:
    timed = [(test["wall_s"], test["id"]) for test in report["tests"] if test["wall_s"] is not None]
    if not timed:
        return
    wall_s, slow = max(timed)
    if wall_s > _SLOW_S and wall_s > _SLOW_FACTOR * sum(each for each, _ in timed) / len(timed):
        yield Line(f"slowest: {seconds(wall_s)} {slow}", "dim")


def _films(report: Mapping[str, Any], columns: int) -> Iterator[Line]:
    films = [test["film"] for test in report["tests"] if test.get("film")]
    if not films:
        return
    made = sum(film["video"] is not None for film in films)
    yield Line(f"films: {made} of {plural(len(films), 'failing test')}, beside the report", "ok" if made else "warn")
    for note, count in Counter(film["note"] for film in films if film["note"]).items():
        for line in wrap(visible(f"{count} {note}").split(" "), columns - 2):
            yield Line(f"  {line}", "warn")


def _row(label: str, text: str, columns: int, style: Style = "plain") -> Iterator[Line]:
    """A label and a text beside it, which goes on below itself where it is too long."""
    start = f"  {pad(visible(label), _LABEL_COLUMNS)}  "
    for line in wrap(visible(text).split(" "), columns - width(start)):
        yield Line(start + line, style)
        start = " " * width(start)
