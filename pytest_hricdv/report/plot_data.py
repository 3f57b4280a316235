"""Data of the page's plots, for `html`: curves of suites, the smallest suite, and heat maps of cross products."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

from pytest_hricdv.report.holes import holes_of_all_suites
from pytest_hricdv.results.model import Report, SuiteResult, TestResult

COLUMNS = 400
"""Most points of a curve: about the width of a plot (pixels) on half a screen, so that thinning is invisible."""
Kind = Literal["statements", "branches", "plans"]
KINDS: tuple[Kind, ...] = ("statements", "branches", "plans")
_LEAST_CHANGE = 1e-12  # smaller changes are rounding errors and would only stretch a logarithmic axis

Point = tuple[float, float]
Places = Sequence[Mapping[str, int]]
"""For each coordinate of a cross product: bin -> its number."""


def closure_curves(suite: SuiteResult) -> dict[str, list[Point]]:
    """Kind of coverage -> (tests run, per cent covered by them together); without kinds that were not measured."""
    curves: dict[str, list[Point]] = {}
    for kind in KINDS:
        total = _total(suite, kind)
        steps = [(step.tests, getattr(step, kind)) for step in suite.curve]
        if total and steps:
            curves[kind] = thin_curve([(tests, round(100.0 * covered / total, 2)) for tests, covered in steps])
    return curves


def learning_curve(suite: SuiteResult) -> list[Point]:
    """(iteration, largest change of Q); a change of 0, which has no logarithm, counts as the least change."""
    changes = enumerate(suite.generation.q_delta, start=1)
    return thin_curve([(number, float(f"{max(change, _LEAST_CHANGE):.4g}")) for number, change in changes])


def minimal_suite(report: Report) -> dict[str, Any]:
    """The smallest suite with the coverage of all tests.

    Returns:
        `curve`: (simulated s, points covered) test by test, `growth`: the same of all tests in the report's order,
        `points` and `sim_s` of all tests, `gains`: number of a test in the report -> points that it adds, of the tests
        of the smallest suite, `unique`: the same with the points that no other test covers.
    """
    closure = report.closure
    numbers = {test.nodeid: number for number, test in enumerate(report.tests)}
    curve: list[Point] = [(0.0, 0.0), *((round(step.sim_s, 2), step.points) for step in closure.minimal)]
    growth: list[Point] = [(0.0, 0.0), *((round(sim_s, 2), points) for sim_s, points in closure.growth)]
    growth.append((round(closure.sim_s, 2), closure.points))
    return {
        "curve": thin_curve(curve),
        "growth": thin_curve(growth),
        "points": closure.points,
        "sim_s": closure.sim_s,
        "gains": {numbers[step.nodeid]: step.gain for step in closure.minimal if step.nodeid in numbers},
        "unique": {numbers[name]: count for name, count in closure.unique.items() if name in numbers},
    }


def heat_maps(report: Report) -> list[dict[str, Any]]:
    """The cross products, each with what its heat map needs.

    Returns:
        `name`, `coordinates` ([name, bins] each), `closed` (["impossible" or "illegal", reason, bit set of bins as a
        hexadecimal number] each), `suites` (suite -> [bin, tests that hit it] each), `tests` (the bins that each
        test of the report hit), `proof`, `holes` (in words). Bins are numbered, the last coordinate's fastest.
    """
    maps = []
    for name, product in sorted(report.cross_products.items()):
        coordinates = [(coordinate.name, coordinate.bins) for coordinate in product.coordinates]
        places = [{name: number for number, name in enumerate(bins)} for _, bins in coordinates]
        closed: dict[tuple[str, str], int] = {}
        for kind, bins in (("impossible", product.impossible), ("illegal", product.illegal)):
            for record in bins:
                closed[kind, record.reason] = closed.get((kind, record.reason), 0) | 1 << _number(record.bin, places)
        maps.append(
            {
                "name": name,
                "coordinates": coordinates,
                "closed": [(kind, reason, f"{bits:x}") for (kind, reason), bits in closed.items()],
                "suites": {suite.name: _suite_hits(suite, name, places) for suite in report.suites},
                "tests": [_test_hits(test, name, places) for test in report.tests],
                "proof": product.proof.reason or "",
                "holes": holes_of_all_suites(report, name),
            }
        )
    return maps


def thin_curve(points: Sequence[Point], columns: int = COLUMNS) -> list[Point]:
    """At most two points per column, the lowest and the highest: a long curve keeps its shape in fewer bytes."""
    if len(points) <= 2 * columns:
        return list(points)
    kept: list[Point] = [points[0]]
    for column in range(columns):
        part = points[column * len(points) // columns : (column + 1) * len(points) // columns]
        kept += sorted({min(part, key=_height), max(part, key=_height)})
    return [*kept, points[-1]]


def _height(point: Point) -> float:
    return point[1]


def _total(suite: SuiteResult, kind: Kind) -> int:
    if kind == "plans":
        return sum(agent.total for agent in suite.plans.values())
    coverage = suite.code.statements if kind == "statements" else suite.code.branches
    return coverage.total if coverage else 0


def _suite_hits(suite: SuiteResult, product: str, places: Places) -> list[tuple[int, int]]:
    coverage = suite.cross.products.get(product)
    return [(_number(hit.bin, places), hit.tests) for hit in coverage.hits] if coverage else []


def _test_hits(test: TestResult, product: str, places: Places) -> list[int]:
    hits = (test.cross or {}).get(product, ())
    return sorted({_number(hit, places) for hit in hits})


def _number(combination: Sequence[str], places: Places) -> int:
    number = 0
    for part, numbers in zip(combination, places, strict=True):
        number = number * len(numbers) + numbers[part]
    return number
