"""The tables and curves of docs/studies/closure.md."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence, Set
from statistics import fmean
from typing import Any

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.extra.closing.view import kind_text
from pytest_hricdv.results.model import Report
from studies import estimates, page, session
from studies.closure.growth import Growth, wanted_points

LOOP = "closure"
WITHOUT = "without "
"""Begins the name of a loop that leaves a strategy out."""

CURVE_STEPS = 200  # points of a curve: more are not told apart at the width of the picture


def context(sessions: Sequence[Growth], report: Report) -> dict[str, Any]:
    """What the page's template is filled with.

    Args:
        sessions: at least one is a whole loop.
        report: of one of them.
    """
    suites = _by_series(growth for growth in sessions if not growth.series.startswith(WITHOUT))
    loops = _by_series(growth for growth in sessions if growth.closing is not None)
    wanted = wanted_points(sessions)
    return {
        "points": len(wanted),
        "horizon_s": horizon_s(sessions),
        "at_time": reached(suites, wanted, sim_s=horizon_s(sessions)),
        "without": without(loops, wanted),
        "strategies": strategies(suites[LOOP]),
        "sessions": len(sessions),
        "seeds": len({growth.seed for growth in sessions}),
        "version": report.version,
        "code_sha256": report.code_under_test.sha256,
        "machine": session.machine(),
    }


def _by_series(sessions: Iterable[Growth]) -> dict[str, list[Growth]]:
    by_series: dict[str, list[Growth]] = {}
    for growth in sessions:
        by_series.setdefault(growth.series, []).append(growth)
    return by_series


def horizon_s(sessions: Iterable[Growth]) -> float:
    """The simulated time (s) that all sessions of whole suites have."""
    return min(growth.sim_s for growth in sessions if not growth.series.startswith(WITHOUT))


def reached(
    by_series: Mapping[str, Sequence[Growth]],
    wanted: Set[Point],
    *,
    sim_s: float | None = None,
    runs: int | None = None,
) -> str:
    """A row for each suite: points of each kind by a time or a number of runs, means over seeds with 95 % intervals."""
    kinds = list(dict.fromkeys(point[0] for point in sorted(wanted)))
    totals = {kind: sum(point[0] == kind for point in wanted) for kind in kinds}
    rows = []
    for name, sessions in by_series.items():
        counts = [growth.reached(wanted, sim_s=sim_s, runs=runs) for growth in sessions]
        cells = [_mean([count[kind] for count in counts]) for kind in kinds]
        rows.append([name, *cells, _mean([count.total() for count in counts])])
    head = ["suite", *(f"{kind_text(kind)} of {totals[kind]}" for kind in kinds), f"all of {len(wanted)}"]
    return page.table(head, rows)


def without(loops: Mapping[str, Sequence[Growth]], wanted: Set[Point]) -> str:
    """A row for each loop: how many closed, its points and runs, and the differences to the whole loop of the seed."""
    head = ["loop", "closed", "bins", f"points of {len(wanted)}", "runs", "points, difference", "runs, difference"]
    whole = {growth.seed: growth for growth in loops[LOOP]}
    return page.table(head, [_compared(name, sessions, whole, wanted) for name, sessions in loops.items()])


def _compared(name: str, sessions: Sequence[Growth], whole: Mapping[int, Growth], wanted: Set[Point]) -> list[str]:
    """A row of `without`; a loop that did not close counts with all of its runs."""
    counts = [growth.reached(wanted) for growth in sessions]
    closed = sum(growth.closing is not None and growth.closing.end_reason == "closed" for growth in sessions)
    own = [
        [count["bin"] for count in counts],
        [count.total() for count in counts],
        [growth.runs for growth in sessions],
    ]
    row = [name, f"{closed} of {len(sessions)}", *map(_mean, own)]
    if name == LOOP:
        return [*row, "-", "-"]
    pairs = [(growth, whole[growth.seed]) for growth in sessions if growth.seed in whole]
    points = [growth.reached(wanted).total() - other.reached(wanted).total() for growth, other in pairs]
    return [*row, _mean(points, signed=True), _mean([growth.runs - other.runs for growth, other in pairs], signed=True)]


def strategies(sessions: Sequence[Growth]) -> str:
    """A row for each strategy: runs and new points of the whole loop, means over seeds."""
    results = [growth.closing.strategies for growth in sessions if growth.closing is not None]
    rows = []
    for name in dict.fromkeys(name for result in results for name in result):
        shares = [result[name] for result in results if name in result]
        runs = sum(share.runs for share in shares) / len(results)
        points = sum(sum(share.new.values()) for share in shares) / len(results)
        bins = sum(share.new.get("bin", 0) for share in shares) / len(results)
        rows.append([name, f"{runs:.1f}", f"{points:.1f}", f"{bins:.1f}"])
    return page.table(["strategy", "runs", "new points", "new bins"], rows)


def curves(sessions: Sequence[Growth], kind: str = "") -> dict[str, list[tuple[float, float]]]:
    """Suite -> (simulated time (s), per cent of the points, or of those of a kind), means over seeds."""
    wanted = {point for point in wanted_points(sessions) if kind in ("", point[0])}
    end_s = horizon_s(sessions)
    times = [end_s * step / CURVE_STEPS for step in range(CURVE_STEPS + 1)]
    suites = _by_series(growth for growth in sessions if not growth.series.startswith(WITHOUT))
    share = 100.0 / max(len(wanted), 1)
    return {
        name: [
            (time_s, share * fmean(growth.reached(wanted, sim_s=time_s).total() for growth in growths))
            for time_s in times
        ]
        for name, growths in suites.items()
    }


def _mean(values: Sequence[float], *, signed: bool = False) -> str:
    """`54.2 (53.1 to 55.0)`, or a dash of none; of one seed nothing is known of others."""
    if not values:
        return "-"
    sign = "+" if signed else ""
    if len(values) == 1:
        return f"{values[0]:{sign}.1f} (one seed)"
    mean = estimates.mean(values)
    return f"{mean.value:{sign}.1f} ({mean.low:{sign}.1f} to {mean.high:{sign}.1f})"
