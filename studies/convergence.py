"""How the step size of physics changes margins, forces and verdicts: some tests at 60, 120, 240 and 480 Hz.

    python -m studies.convergence [--write]

Each rate runs in a separate process. `--write` replaces the table in docs/studies/convergence.md.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from studies import page
from studies.session import ROOT

if TYPE_CHECKING:
    from pytest_hricdv.execution.case import CaseResult
    from pytest_hricdv.generate.concrete import ConcreteTest

DOCUMENT = ROOT / "docs" / "studies" / "convergence.md"
COMMAND = "python -m studies.convergence --write"
RATES_HZ = (60, 120, 240, 480)  # half, once, twice and four times what the world has
PULL_N = 8.0  # in the middle of the declared range of pulls
REQUIREMENTS = ("R1", "R2", "R3", "R4", "R5")

SAME = ("verdicts", "legs")
DIFFERENCES: Mapping[str, str] = {
    "fastest": "fastest joint, rad/s",
    "margin_r3": "R3 margin, m",
    "margin_r1": "R1 margin, s",
    "reaction": f"pull of {PULL_N:g} N as felt, N",
    "contact": "force on hand, N",
}
TOTALS = ("largest slip in the hand, mm", "CPU time, s")


def main() -> None:
    """Measure at each rate and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="replace the table in docs/studies/convergence.md")
    parser.add_argument("--at", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.at:
        print(json.dumps(measure(options.at)))
        return
    by_rate = {rate: child(rate) for rate in RATES_HZ}
    text = table(by_rate)
    print(text)
    if options.write:
        page.replace_figures(DOCUMENT, COMMAND, text)


def child(rate_hz: int) -> dict[str, dict[str, Any]]:
    """The figures at one rate: test -> column -> value."""
    command = [sys.executable, "-m", "studies.convergence", "--at", str(rate_hz)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(done.stderr)
    figures: dict[str, dict[str, Any]] = json.loads(done.stdout)
    return figures


def table(by_rate: Mapping[int, Mapping[str, Mapping[str, Any]]]) -> str:
    """A row for each rate: the largest difference of each figure from the highest rate, over the tests."""
    reference = by_rate[max(by_rate)]
    rows = []
    for rate, figures in by_rate.items():
        same = sum(figures[name][key] == reference[name][key] for name in figures for key in SAME)
        differences = [shown(largest_difference(figures, reference, key)) for key in DIFFERENCES]
        totals = [shown(max(test["slip"] for test in figures.values())), shown(sum(t["cpu"] for t in figures.values()))]
        rows.append([rate, f"{same} of {len(SAME) * len(figures)}", *differences, *totals])
    return page.table(["Hz", "same verdicts and ends", *DIFFERENCES.values(), *TOTALS], rows)


def largest_difference(
    figures: Mapping[str, Mapping[str, Any]], reference: Mapping[str, Mapping[str, Any]], key: str
) -> float:
    """The largest difference of a figure, over the tests that have it."""
    pairs = ((test[key], reference[name][key]) for name, test in figures.items())
    differences = [abs(value - other) for value, other in pairs if None not in (value, other)]
    return float(max(differences))


def shown(value: object) -> str:
    """A number with four digits, a text as it is, a dash for None."""
    return "-" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)


def measure(rate_hz: int) -> dict[str, dict[str, Any]]:
    """Run all tests in this process at one rate. No other module of sim/ may be imported before."""
    from sim import engine

    engine.STEP_HZ = rate_hz
    engine.STEP_S = 1.0 / rate_hz
    engine.TICK_STEPS = rate_hz // engine.TICK_HZ
    return {name: figures(test) for name, test in tests().items()}


def tests() -> dict[str, ConcreteTest]:
    """One test of each kind: handed over, discarded, hand near or between the closing fingers, fingers held."""
    from tests.hri import bench

    pulled = {"pull_n": PULL_N}
    stray = {"rest_x_m": 0.48, "rest_y_m": -0.3, "rest_z_m": 0.62}
    between = {"rest_x_m": 0.38, "rest_y_m": -0.3, "rest_z_m": 0.62}
    return {
        "A leg handed over": bench.concrete(bench.leg(), seed=1, **pulled),
        "A leg not taken, discarded": bench.concrete(bench.leg("110"), seed=1, **pulled),
        "The person's hand beside the closing fingers": bench.concrete(bench.leg(), seed=1, **pulled, **stray),
        "The person's hand between the closing fingers": bench.concrete(bench.leg(), seed=1, **pulled, **between),
        "The person grips hand and leg for 6 s": bench.concrete(bench.leg(), seed=1, grip_s=6.0, **pulled),
        "The person grips hand and leg for 12 s": bench.concrete(bench.leg(), seed=1, grip_s=12.0, **pulled),
    }


def figures(test: ConcreteTest) -> dict[str, Any]:
    """The figures of one run, by column."""
    from tests.hri import bench

    bench.run(test)  # the first run plans the paths
    began_s = time.process_time()
    with observed() as seen:
        result = bench.run(test)
    cpu_s = time.process_time() - began_s
    margins = {verdict.requirement: verdict.margin for verdict in result.verdicts}
    return {
        "verdicts": " ".join(result.verdict(requirement).verdict for requirement in REQUIREMENTS),
        "legs": ", ".join(result.outcome.outcomes),
        "fastest": largest(result, "arm_speed"),
        "margin_r3": margins["R3"],
        "margin_r1": margins["R1"],
        "reaction": statistics.median(seen.felt_n) if seen.felt_n else None,
        "contact": largest(result, "hand_contact_force"),
        "slip": 1000.0 * seen.slip_m,
        "cpu": cpu_s,
    }


@dataclass
class HandMeasurements:
    """Quantities that are only seen inside the world."""

    felt_n: list[float] = field(default_factory=list)
    slip_m: float = 0.0


@contextmanager
def observed() -> Iterator[HandMeasurements]:
    """Observe the leg in the robot's hand at every control tick."""
    from sim.world import World

    seen, tick = HandMeasurements(), World._tick
    grasped: dict[int, Sequence[float]] = {}

    def observed_tick(world: World) -> None:
        tick(world)
        leg = world.legs.in_hand
        if leg is not None:
            place = world.torso.to_palm(leg.pose())[0]
            seen.slip_m = max(seen.slip_m, math.dist(place, grasped.setdefault(leg.body, place)))
            if world.person.pull_now() >= PULL_N:
                seen.felt_n.append(world.pressure.change_n())

    World._tick = observed_tick  # type: ignore[method-assign, assignment]
    try:
        yield seen
    finally:
        World._tick = tick  # type: ignore[method-assign]


def largest(result: CaseResult, signal: str) -> float:
    """The largest value of a signal."""
    values: Sequence[float] = result.record.signals[signal][1]
    return max(values)


if __name__ == "__main__":
    main()
