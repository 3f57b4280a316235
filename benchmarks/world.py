"""Speed of the simulated world in complete tests, with coverage, monitors and record: medians.

    python -m benchmarks.world [--repeat N]

Each figure is shown with that of the physics engine alone, measured in a run of its own beside it, as the clock costs
time too, and with their ratio: engine alone to everything. All figures are for one core; ratios are the same on a busy
machine, nearly.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from pytest_hricdv.coverage.code_map import map_code
from pytest_hricdv.coverage.measurement import Measurement, choose
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.runtime import Recorder
from sim import workshop
from sim.world import World
from studies.session import machine
from tests.hri import bench

STEPPING = {"pybullet": ("pybullet", "stepSimulation"), "mujoco": ("mujoco", "mj_step")}
"""Engine -> module and function that computes a step."""

WAIT_S = 78.0
"""The person of the handover test waits this long before the request, so that the test takes about 120 s."""


@dataclass(frozen=True)
class Pace:
    """Simulated time, CPU time, and how much of it the steps of the physics engine alone take (s)."""

    sim_s: float
    stepped_s: float
    cpu_s: float
    engine_s: float

    def __str__(self) -> str:
        rate, bare = self.sim_s / self.cpu_s, self.sim_s / self.engine_s
        moving = self.stepped_s / self.sim_s
        return f"{rate:6.0f} x real time (engine alone {bare:6.0f} x, 1 to {self.ratio:.2f}; stepped {moving:4.0%})"

    @property
    def ratio(self) -> float:
        """Of everything to the engine alone."""
        return self.cpu_s / self.engine_s


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeat", type=int, default=5, metavar="N", help="runs of each measurement (default 5)")
    options = parser.parse_args()
    print(f"machine: {machine()}\nmedians of {options.repeat}")
    measurement = choose(map_code(bench.testbench().code, bench.ROOT), contexts_by_test=False)
    handover, four = one_handover(), bench.concrete(bench.leg() * 4, seed=4)
    for engine in filter(find_spec, STEPPING):
        print(f"\n{engine}: world built and closed in {1000.0 * build_s(engine, options.repeat):.1f} ms")
        bench.run(handover, measurement, engine)
        for name, test in (("120 s, one handover", handover), ("four handovers", four)):
            for how, frozen in (("freezing", True), ("every step computed", False)):
                with freezing(frozen):
                    print(f"{name:20} {how:20} {pace(test, measurement, engine, options.repeat)}", flush=True)


def one_handover() -> ConcreteTest:
    """One handover from request to release: about 120 s."""
    test = bench.concrete(bench.leg(), seed=1)
    ask, *rest = test.actions
    late = replace(ask, parameters={**ask.parameters, "voice_s": WAIT_S})
    return replace(test, actions=(late, *rest))


def build_s(engine: str, repeat: int) -> float:
    """Median time (s) of building a world and closing it."""

    def once() -> None:
        World(Recorder(), engine=engine).close()

    return statistics.median(timed(once) for _ in range(repeat + 2))


def pace(test: ConcreteTest, measurement: Measurement, engine: str, repeat: int) -> Pace:
    """The run of a test with the median ratio to the engine alone."""
    return sorted((run(test, measurement, engine) for _ in range(repeat)), key=lambda paced: paced.ratio)[repeat // 2]


def run(test: ConcreteTest, measurement: Measurement, engine: str) -> Pace:
    """Two runs: of one the time of all is measured, of the other that of the engine's steps."""
    began_s = time.thread_time()
    result = bench.run(test, measurement, engine)
    cpu_s = time.thread_time() - began_s
    with clocked(*STEPPING[engine]) as spent:
        bench.run(test, measurement, engine)
    return Pace(result.sim_s, result.sim_s - result.outcome.skipped_s, cpu_s, sum(spent))


@contextmanager
def clocked(library: str, function: str) -> Iterator[list[float]]:
    """Measure the duration (s) of every call of a function of an engine's library."""
    engine = import_module(library)
    original: Callable[..., Any] = getattr(engine, function)
    spent: list[float] = []
    clock = time.thread_time  # process time is inexact while the watchdog's timer runs

    def clocking(*arguments: Any, **more: Any) -> Any:
        began_s = clock()
        answer = original(*arguments, **more)
        spent.append(clock() - began_s)
        return answer

    setattr(engine, function, clocking)
    try:
        yield spent
    finally:
        setattr(engine, function, original)


@contextmanager
def freezing(on: bool) -> Iterator[None]:
    """Switch freezing on or off."""
    original = workshop.Workshop
    workshop.Workshop = partial(original, freeze=on)  # type: ignore[misc, assignment]
    try:
        yield
    finally:
        workshop.Workshop = original  # type: ignore[misc]


def timed(action: Callable[[], None]) -> float:
    """CPU time (s) of an action."""
    began_s = time.thread_time()
    action()
    return time.thread_time() - began_s


if __name__ == "__main__":
    main()
