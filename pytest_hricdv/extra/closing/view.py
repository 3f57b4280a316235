"""`ClosingView`: shows the closing loop of a report, in lines of the terminal and in a section of the page.

The report calls it by way of `registry`. `page` makes the section from the loop's `ClosingResult`.
"""

import shlex
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.closing.feature import NAME
from pytest_hricdv.extra.closing.records import (
    CLOSING,
    RULE_OF_THREE,
    ClosingResult,
    GrowthStep,
    NearestRun,
    OpenPoint,
    ViolationEstimate,
    ViolationKind,
)
from pytest_hricdv.report.formatting import (
    Line,
    by_requirement,
    pad,
    percent,
    plural,
    quantity,
    seconds,
    width,
)
from pytest_hricdv.report.tests_view import anchor
from pytest_hricdv.report.view import PageSection, View
from pytest_hricdv.report.violations import margin_text, margin_unit
from pytest_hricdv.results.model import Report

_MAX_OPEN = 9
"""Maximum number of open points in the terminal, a line each: one of each kind of targets, and some more."""

_MAX_VIOLATIONS = 5
"""Maximum number of new violations in the terminal, a line each."""

_MAX_NEAR = 3
"""Maximum number of requirements in the terminal that are nearest to a violation, on one line."""

_KINDS = {"verdict": "verdicts", "branch": "branches"}  # kind of points -> its plural
_ENDED = {
    "closed": "nothing is open",
    "runs": "the budget of runs is used up",
    "seconds": "the budget of time is used up",
    "nothing to try": "no strategy proposes another test",
    "interrupted": "interrupted",
    "error": "an error of the loop itself",
}

Point = tuple[float, float]  # of a curve: x and y


class ClosingView(View):
    """The points of a closing loop by kind, those left open, and the violations that it found."""

    name = "closing"
    scripts = ("closing",)

    def lines(self, report: Report, columns: int) -> Iterator[Line]:
        """The points by kind, and the open ones; empty if there was no closing loop."""
        result = CLOSING.of(report)
        if result is None:
            return
        yield Line(headline(result), "title")
        room = max([14, *(width(visible(kind_text(kind))) for kind in result.kinds)])
        yield Line(f"  {pad('points', room)}{'hit':>7}{'impossible':>12}{'open':>7}", "dim")
        for kind, count in result.kinds.items():
            text = f"  {pad(visible(kind_text(kind)), room)}{count.hit:>7}{count.impossible:>12}{count.open:>7}"
            yield Line(text)
        for text in notes(result):
            yield Line(f"  {text}", "dim")
        yield from _violations(result)
        nearest = ", ".join(near_text(near, report) for near in nearest_first(result)[:_MAX_NEAR])
        if nearest:
            yield Line(visible(f"  nearest to a violation: {nearest}"), "dim")
        for point in _select_points(result.open):
            yield Line(visible(f"  open: {point_text(point.point)}: {evidence_text(point)}"), "warn")
        if len(result.open) > _MAX_OPEN:
            yield Line(f"  open: {len(result.open) - _MAX_OPEN} more: see the report", "warn")

    def section(self, report: Report) -> PageSection | None:
        """A part of the view of closure."""
        values = page(report)
        return (
            None if values is None else PageSection("closing", "", "closing/closing.html.jinja", values, "in closure")
        )

    def aim(self, report: Report) -> str:
        """A closing loop after the same suites; after a loop, with twice its budget; none after a loop that closed."""
        if not report.rerun_options.suite or not report.suites:
            return ""
        result = CLOSING.of(report)
        if result is not None and result.end_reason == "closed":
            return ""  # the rest is no target of a loop
        options = [option for option in report.rerun_options.options if not option.startswith("--hri-close")]
        words = [f"--hri-suite={report.rerun_options.suite}", f"--hri-seed={report.suites[0].seed}", *options]
        if NAME not in report.rerun_options.suite.split(","):
            words.append("--hri-close")
        if result is not None:
            words.append(f"--hri-close-runs={2 * result.budget}")
        return " ".join(("pytest", *map(shlex.quote, words)))

    def data(self, report: Report) -> dict[str, Any]:
        """The plots' curves."""
        return {"closing": curves(report)}


VIEW = ClosingView()


_LISTED_ANYWAY = frozenset({"statement", "branch", "plan", "bin"})
"""Kinds of points that count as gaps, with or without a closing loop."""


def _select_points(points: Sequence[OpenPoint]) -> list[OpenPoint]:
    """Some points of each kind, those with most tries; the kinds that every summary lists come last."""
    most_tried = sorted(points, key=lambda point: -point.tries)
    places: Counter[str] = Counter()
    ranked = []
    for number, point in enumerate(most_tried):
        places[point.point[0]] += 1
        ranked.append((places[point.point[0]], number))
    chosen = {number for _, number in sorted(ranked)[:_MAX_OPEN]}
    kinds = list(dict.fromkeys(point.point[0] for point in points))
    shown = [point for number, point in enumerate(most_tried) if number in chosen]
    return sorted(shown, key=lambda point: (point.point[0] in _LISTED_ANYWAY, kinds.index(point.point[0])))


def _violations(result: ClosingResult) -> Iterator[Line]:
    new = [violation for violation in result.violations if not violation.known]
    for violation in new[:_MAX_VIOLATIONS]:
        text = f"  violated: {violation_text(violation)}: {plural(violation.runs, 'run')} ({violation.test})"
        yield Line(visible(text), "bad")
    more = plural(len(new[_MAX_VIOLATIONS:]), "more kind") if len(new) > _MAX_VIOLATIONS else ""
    others = f"{len(result.violations) - len(new)} known" if len(result.violations) > len(new) else ""
    if more or others:
        yield Line(f"  kinds of violations: {', '.join(filter(None, (more, others)))}, see the report", "dim")


def violation_text(violation: ViolationKind) -> str:
    """`R4 (arm_speed < 0.25) in Reset, released`: what is violated, in which state, and how the interaction ended."""
    violated = f"{violation.requirement} ({violation.part})" if violation.requirement else violation.part
    where = f" in {violation.state}" if violation.state else ""
    return violated + where + (f", {violation.outcome}" if violation.outcome else "")


def headline(result: ClosingResult) -> str:
    """`closing: 400 runs, 30211 s simulated; ended: the budget of runs is used up`."""
    return (
        f"closing: {plural(result.runs, 'run')}, {seconds(result.sim_s)} simulated; ended: {_ENDED[result.end_reason]}"
    )


def notes(result: ClosingResult) -> Iterator[str]:
    """Notes on another run, and on runs that did not end, a sentence each."""
    if result.errored_runs:
        yield f"{plural(result.errored_runs, 'run')} did not end"
    if result.searched:
        yield f"{plural(result.searched, 'run')} of these searched for violations where margins were smallest"
    if result.estimated_undetected is not None:
        yield kinds_left_text(result.estimated_undetected)


def kinds_left_text(estimate: ViolationEstimate) -> str:
    """The probable finds of another run: an estimate, as runs of a loop are not independent."""
    if not estimate.once:
        bound = percent(100.0 * min(1.0, RULE_OF_THREE / estimate.runs))
        seen = f"no new violation in {plural(estimate.runs, 'run')}"
        seen = "all kinds of violations recurred" if estimate.kinds else seen
        return f"{seen}: below {bound} of runs show another (95 %)"
    kinds = f"{estimate.once} of {estimate.kinds} came once"
    return f"a further run would find {quantity(estimate.new)} more kinds of violations ({kinds})"


def nearest_first(result: ClosingResult) -> list[NearestRun]:
    """Requirements that are not violated, ordered by least margin relative to the spread of their margins."""
    violated = {violation.requirement for violation in result.violations}
    near = [
        run for run in result.closest_runs if run.requirement not in violated and run.margin is not None and run.spread
    ]
    return sorted(near, key=lambda run: ((run.margin or 0.0) / (run.spread or 1.0), by_requirement(run.requirement)))


def near_text(near: NearestRun, report: Report) -> str:
    """`R7 by 1.5 s`: how near a requirement came to a violation."""
    margin = margin_text(near.margin or 0.0, margin_unit(report, near.requirement))
    return f"{near.requirement} by {margin}"


def kind_text(kind: str) -> str:
    """`statements`: the name of a kind of points."""
    return _KINDS.get(kind, f"{kind}s")


def point_text(point: Sequence[str]) -> str:
    """`controller/robot.py:42`, `controller/robot.py:42->44`, `decision: 101 x released`, `R5 Passed`."""
    match point:
        case ("statement", file, line):
            return f"{file}:{line}"
        case ("branch", file, begin, end):
            return f"{file}:{begin}->{'exit' if end.startswith('-') else end}"
        case ("bin", product, *parts):
            return f"{product}: {' x '.join(parts)}"
        case ("plan", agent, label):
            return f"{agent}: {label}"
        case ("condition", requirement, conjunct, outcome):
            return f"{requirement}: {conjunct} {outcome}"
        case ("transition", state, following):
            return f"{state} -> {following}"
        case (_, *names):
            return " ".join(names)
    return ""


def evidence_text(point: OpenPoint) -> str:
    """`outcome released instead of discarded (closure-...); 120 tries, below 2.5 %`: narrow terminals cut the end."""
    nearest = f"{point.lacking} ({point.test})" if point.test else point.lacking
    return "; ".join(filter(None, (nearest.strip(), tries_text(point))))


def tries_text(point: OpenPoint) -> str:
    """`120 tries, below 2.5 %`: the runs aimed at a point, and what that says of their chance, if anything."""
    if point.bound is None:
        return "never aimed at"
    tries = f"{point.tries} {'try' if point.tries == 1 else 'tries'}"
    return f"{tries}, below {percent(100.0 * point.bound)}" if point.bound < 1 else tries


def page(report: Report) -> dict[str, Any] | None:
    """The section of the page; None without a closing loop."""
    result = CLOSING.of(report)
    if result is None:
        return None
    anchors = {test.id: anchor(test.nodeid) for test in report.tests}
    used = {id: text for id, text in result.closest_tests.items() if id not in anchors}
    return {
        "result": result,
        "headline": headline(result),
        "notes": [*notes(result)],
        "near": [
            (near, margin_text(near.margin, margin_unit(report, near.requirement)) if near.margin is not None else "-")
            for near in sorted(result.closest_runs, key=lambda near: by_requirement(near.requirement))
        ],
        "kinds": {kind_text(kind): count for kind, count in result.kinds.items()},
        "anchors": anchors,
        "open": _open_by_place(result),
        "nearest": used,
        "replays": {test.id: test.replay for test in report.tests if test.replay},
        "impossible": _reasons(result),
    }


def _open_by_place(result: ClosingResult) -> list[tuple[str, str, list[tuple[OpenPoint, str, str]]]]:
    """Open points by place (a file, a product, ...): number and kind, and for each its text and its tries."""
    places: dict[tuple[str, str], list[tuple[OpenPoint, str, str]]] = {}
    for point in result.open:
        kind, *names = point.point
        where = names[0] if len(names) > 1 else ""
        places.setdefault((kind, where), []).append((point, point_text(point.point), tries_text(point)))
    ordered = sorted(places.items(), key=lambda item: -len(item[1]))
    return [(plural(len(points), kind), where, points) for (kind, where), points in ordered]


def _reasons(result: ClosingResult) -> list[tuple[str, str, str, int]]:
    """Kind, by what, why, and how many points are impossible for this reason."""
    counts = Counter((kind_text(point.point[0]), point.by, point.reason) for point in result.impossible)
    return [(kind, by, reason, count) for (kind, by, reason), count in counts.items()]


def curves(report: Report) -> dict[str, Any] | None:
    """Plain data for the plots: points hit over runs and simulated time (s).

    Returns:
        `kinds`: kind -> per cent of its possible points, over `runs` and over `sim_s`; `strategies`: strategy -> how
            many points it hit first, over the same.
    """
    result = CLOSING.of(report)
    if result is None:
        return None
    kinds = {}
    for kind, count in result.kinds.items():
        # Impossible points do not count, unless they were hit.
        share = 100.0 / max(count.hit + count.open, 1)
        kinds[kind_text(kind)] = _series(result, [(step, share * step.new.get(kind, 0)) for step in result.growth])
    strategies = {}
    for strategy in result.strategies:
        steps = [(step, float(sum(step.new.values()))) for step in result.growth if step.strategy == strategy]
        strategies[strategy] = _series(result, steps)
    return {"kinds": kinds, "strategies": strategies}


def _series(result: ClosingResult, steps: Iterable[tuple[GrowthStep, float]]) -> dict[str, list[Point]]:
    """The sum so far, from the beginning to the end of the loop."""
    total = 0.0
    runs: list[Point] = [(0, 0.0)]
    sim_s: list[Point] = [(0.0, 0.0)]
    for step, gain in steps:
        if gain:
            total += gain
            runs.append((step.run, round(total, 2)))
            sim_s.append((round(step.sim_s, 1), round(total, 2)))
    runs.append((result.runs, round(total, 2)))
    sim_s.append((round(result.sim_s, 1), round(total, 2)))
    return {"runs": runs, "sim_s": sim_s}
