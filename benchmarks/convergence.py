"""What the step size of physics changes: margins, forces and verdicts of some tests at 60, 120, 240 and 480 Hz.

    python -m benchmarks.convergence [--write]

Each rate runs in a process of its own. `--write` puts the tables into docs/convergence.md, below the text there.
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
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pytest_hricdv.case import CaseResult
    from pytest_hricdv.generate.concrete import ConcreteTest

ROOT = Path(__file__).parents[1]
DOCUMENT = ROOT / "docs" / "convergence.md"
MARK = "<!-- figures: python -m benchmarks.convergence --write -->"
RATES_HZ = (60, 120, 240, 480)
PULL_N = 8.0
REQUIREMENTS = ("R1", "R2", "R3", "R4", "R5")

COLUMNS: Mapping[str, str] = {
    "verdicts": "R1 to R5",
    "legs": "legs",
    "fastest": "fastest joint, rad/s",
    "margin_r3": "R3 margin, m",
    "margin_r1": "R1 margin, s",
    "reaction": "pull felt, N (8 N pulled)",
    "contact": "force on hand, N",
    "slip": "slip in the hand, mm",
    "cpu": "s of processor",
}


def main() -> None:
    """Measure at each rate and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="put the tables into docs/convergence.md")
    parser.add_argument("--at", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.at:
        print(json.dumps(measure(options.at)))
        return
    by_rate = {rate: child(rate) for rate in RATES_HZ}
    text = tables(by_rate)
    print(text)
    if options.write:
        head = DOCUMENT.read_text(encoding="utf-8").partition(MARK)[0]
        DOCUMENT.write_text(f"{head}{MARK}\n\n{text}\n", encoding="utf-8")


def child(rate_hz: int) -> dict[str, dict[str, Any]]:
    """The figures at one rate: test -> column -> value."""
    command = [sys.executable, "-m", "benchmarks.convergence", "--at", str(rate_hz)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(done.stderr)
    figures: dict[str, dict[str, Any]] = json.loads(done.stdout)
    return figures


def tables(by_rate: Mapping[int, Mapping[str, Mapping[str, Any]]]) -> str:
    """One table a test: a row a rate."""
    parts = []
    for name in next(iter(by_rate.values())):
        rows = [["Hz", *COLUMNS.values()], ["---"] * (len(COLUMNS) + 1)]
        rows += [[str(rate), *(shown(figures[name][key]) for key in COLUMNS)] for rate, figures in by_rate.items()]
        parts.append(f"**{name}**\n\n" + "\n".join("| " + " | ".join(row) + " |" for row in rows))
    return "\n\n".join(parts)


def shown(value: object) -> str:
    """A figure with four digits, a text as it is, nothing as a dash."""
    return "-" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)


def measure(rate_hz: int) -> dict[str, dict[str, Any]]:
    """Run all tests in this process, with physics at a rate; nothing of the world may be imported before."""
    from sim import physics_time

    physics_time.STEP_HZ = rate_hz
    physics_time.STEP_S = 1.0 / rate_hz
    physics_time.TICK_STEPS = rate_hz // physics_time.TICK_HZ
    return {name: figures(test) for name, test in tests().items()}


def tests() -> dict[str, ConcreteTest]:
    """One of each kind: handed over, hand elsewhere, hand near the closing fingers, hand between them, fingers held."""
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
    """What one run gives, by column."""
    from tests.hri import bench

    bench.run(test)  # ways are planned once
    began_s = time.process_time()
    with watched() as seen:
        result = bench.run(test)
    cpu_s = time.process_time() - began_s
    margins = {verdict.requirement: verdict.margin for verdict in result.verdicts}
    return {
        "verdicts": " ".join(result.verdict(each).verdict for each in REQUIREMENTS),
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
class Seen:
    """What only a look into the world shows."""

    felt_n: list[float] = field(default_factory=list)
    slip_m: float = 0.0


@contextmanager
def watched() -> Iterator[Seen]:
    """Look at every control tick at the leg in the robot's hand."""
    from sim.engine import bullet
    from sim.world import World

    seen, tick = Seen(), World._tick
    grasped: dict[int, Sequence[float]] = {}

    def looking(world: World) -> None:
        tick(world)
        leg = world.legs.in_hand
        if leg is not None:
            back = bullet.invertTransform(*world.torso.palm_pose())
            place: Sequence[float] = bullet.multiplyTransforms(*back, *leg.pose())[0]
            seen.slip_m = max(seen.slip_m, math.dist(place, grasped.setdefault(leg.body, place)))
            if world.person.pull_now() >= PULL_N:
                seen.felt_n.append(world.pressure.change_n())

    World._tick = looking  # type: ignore[method-assign]
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
