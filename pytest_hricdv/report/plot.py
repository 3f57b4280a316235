"""The charts of a report: coverage per test, closure, and what learning did."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from pytest_hricdv.report.axis import Axis, linear, logarithmic
from pytest_hricdv.report.chart import Curve, Point, svg
from pytest_hricdv.report.line import visible

_LEAST_CHANGE = 1e-12  # what is less is rounding, and would only stretch the axis


@dataclass(frozen=True)
class Plot:
    """A chart with its heading, what it shows in a sentence, and the curves for a legend."""

    title: str
    about: str
    svg: str
    curves: tuple[Curve, ...]


def coverage_per_test(report: Mapping[str, Any]) -> Plot | None:
    """Statement coverage of each test in ascending order, a curve a suite; None where nothing was measured."""
    curves = []
    for number, suite in enumerate(report["suites"]):
        percents = sorted(
            float(test["code"]["percent"])
            for test in report["tests"]
            if test["suite"] == suite["name"] and test["code"] and test["code"]["percent"] is not None
        )
        points = tuple((float(rank), value) for rank, value in enumerate(percents, start=1))
        curves.append(_named(suite, number, points))
    return _plot(
        "Coverage per test",
        "Statements of the code under test that each test covers by itself, tests in ascending order.",
        curves,
        "tests, in ascending order of coverage",
        "statements covered (%)",
    )


def closure(report: Mapping[str, Any]) -> tuple[Plot, ...]:
    """Coverage reached after so many tests, a curve a suite, for whatever was measured of the three kinds."""
    plots = (_closure(report, kind) for kind in ("statements", "branches", "plans"))
    return tuple(plot for plot in plots if plot is not None)


def learning(report: Mapping[str, Any]) -> Plot | None:
    """Largest change of Q in each iteration, a curve a suite that was learned; None where none was."""
    curves = []
    for number, suite in enumerate(report["suites"]):
        changes = suite["generation"]["q_delta"]
        converged = suite["generation"]["converged_at"]
        note = "not converged" if converged is None else f"converged at {converged}"
        points = tuple((float(n), float(change)) for n, change in enumerate(changes, start=1))
        curves.append(_named(suite, number, points, note))
    values = [change for curve in curves for _, change in curve.points]
    positive = [change for change in values if change >= _LEAST_CHANGE]
    # No change at all has no logarithm: it is drawn on the lower edge, a decade below the least change.
    below = 10 if len(positive) < len(values) else 1
    label = "largest change of Q"
    y = logarithmic(label, min(positive) / below, max(positive)) if positive else linear(label, 0, 1)
    about = "Largest change of a cell of Q in each iteration, logarithmic; learning stops when it stays small."
    return _plot("Learning", about, curves, "iteration", label, y)


def _closure(report: Mapping[str, Any], kind: str) -> Plot | None:
    curves = []
    for number, suite in enumerate(report["suites"]):
        total = _total(suite, kind)
        points = tuple(
            (float(step["tests"]), 100.0 * step[kind] / total)
            for step in suite["curve"]
            if total and step.get(kind) is not None
        )
        curves.append(_named(suite, number, points))
    what = "plans of all agents" if kind == "plans" else f"{kind} of the code under test"
    about = f"Share of the {what} covered by the first tests together."
    return _plot(f"Closure: {kind}", about, curves, "tests run", f"{kind} covered (%)")


def _total(suite: Mapping[str, Any], kind: str) -> int:
    if kind == "plans":
        return sum(figures["total"] for figures in suite["plans"].values())
    return suite["code"][kind]["total"] if suite["code"][kind] else 0


def _named(suite: Mapping[str, Any], number: int, points: tuple[Point, ...], note: str = "") -> Curve:
    return Curve(visible(suite["name"]), points, number, note)


def _plot(title: str, about: str, curves: list[Curve], across: str, up: str, y: Axis | None = None) -> Plot | None:
    drawn = tuple(curve for curve in curves if curve.points)
    if not drawn:
        return None
    values = list(_values(drawn))
    # Per cent from the ten below the lowest value: the differences between suites lie in the upper part.
    low = (min(values) - 2) // 10 * 10
    y_axis = y or linear(up, low if low >= 20 else 0, 100)
    x_axis = linear(across, 0, max(curve.points[-1][0] for curve in drawn), whole=True)
    return Plot(title, about, svg(title, drawn, x_axis, y_axis), drawn)


def _values(curves: tuple[Curve, ...]) -> Iterator[float]:
    return (up for curve in curves for _, up in curve.points)
