"""The series that the page plots, thinned to what a plot can show."""

from collections.abc import Mapping, Sequence
from typing import Any

from pytest_hricdv.report.figure import natural

COLUMNS = 400
KINDS = ("statements", "branches", "plans")
_LEAST_CHANGE = 1e-12  # what is less is rounding, and would only stretch a logarithmic axis

Point = tuple[float, float]


def closure(suite: Mapping[str, Any]) -> dict[str, list[Point]]:
    """Kind of coverage -> (tests run, per cent covered by them together); without kinds that were not measured."""
    found = {}
    for kind in KINDS:
        total = _total(suite, kind)
        steps = [step for step in suite["curve"] if total and step.get(kind) is not None]
        if steps:
            found[kind] = thinned([(step["tests"], round(100.0 * step[kind] / total, 2)) for step in steps])
    return found


def learning(suite: Mapping[str, Any]) -> list[Point]:
    """(iteration, largest change of Q); no change at all, which has no logarithm, counts as the least."""
    changes = suite["generation"]["q_delta"]
    return thinned([(n, float(f"{max(change, _LEAST_CHANGE):.4g}")) for n, change in enumerate(changes, start=1)])


def triggers(report: Mapping[str, Any], requirement: str, bins: int = 60) -> dict[str, Any] | None:
    """How often a requirement triggered in each span of simulated time, suite by suite; None where it never did.

    Returns:
        `width_s` of a span, and `suites`: name -> triggers in each span from 0 s on.
    """
    begins: dict[str, list[float]] = {}
    for test in report["tests"]:
        attempts = ((test.get("timeline") or {}).get("attempts") or {}).get(requirement, "")
        begins.setdefault(test["suite"], []).extend(float(each.partition("-")[0]) for each in attempts.split())
    last_s = max((time_s for times in begins.values() for time_s in times), default=None)
    if last_s is None:
        return None
    width_s = next(w for w in (0.1, 0.5, 1, 2, 5, 10, 20, 60, 300, 1800, 86400, last_s + 1) if w * bins > last_s)
    counts = {name: [0] * (int(last_s / width_s) + 1) for name in sorted(begins, key=natural) if begins[name]}
    for name, times in begins.items():
        for time_s in times:
            counts[name][int(time_s / width_s)] += 1
    return {"width_s": width_s, "suites": counts}


def thinned(points: Sequence[Point], columns: int = COLUMNS) -> list[Point]:
    """At most two points a column, the lowest and the highest: a long curve keeps its shape and not its bytes."""
    if len(points) <= 2 * columns:
        return list(points)
    kept: list[Point] = [points[0]]
    for column in range(columns):
        part = points[column * len(points) // columns : (column + 1) * len(points) // columns]
        kept += sorted({min(part, key=_height), max(part, key=_height)})
    return [*kept, points[-1]]


def _height(point: Point) -> float:
    return point[1]


def _total(suite: Mapping[str, Any], kind: str) -> int:
    if kind == "plans":
        return sum(figures["total"] for figures in suite["plans"].values())
    return suite["code"][kind]["total"] if suite["code"][kind] else 0
