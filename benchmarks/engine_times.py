"""Times of the BDI engines, as `python -m benchmarks.bdi_engine` shows them: one a line, a name, a tab and seconds."""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

from pytest_hricdv.bdi import Environment, MultiAgentSystem
from pytest_hricdv.bdi.system import Engine
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.learner import learn
from pytest_hricdv.generate.model import Model, ModelRun
from pytest_hricdv.generate.model_runner import ModelRunner
from pytest_hricdv.generate.qlearning import QLearning

ROOT = Path(__file__).parents[1]
TABLE = ROOT / "models_bdi" / "table_assembly.mas2j"
SPINNING = ROOT / "benchmarks" / "spinning" / "spinning.mas2j"
FOUR_LEGS = ("leg1", "m111l1", "m111l2", "m111l3", "m111l4")
SPACE = BeliefSpace(
    start=("leg1", "leg2", "leg3", "leg4"),
    groups={
        "boredom": ("bored", "not_bored"),
        **{f"pose{leg}": tuple(f"m{pose:03b}l{leg}" for pose in range(8)) for leg in range(1, 5)},
    },
    neutral=("not_bored",),
)
ENGINES: tuple[Engine, ...] = ("interpreter", "compiled")
LEARNING = """
import time
began = time.perf_counter()
from benchmarks.engine_times import learn_all
learn_all()
print(time.perf_counter() - began)
"""
COUNTS = ((1_000, 1), (10_000, 1), (1_000, 10), (1_000, 100))
"""Rounds and agents that count."""
COUNTER = "count(0). !go. +!go : count(N) & N < {rounds} <- -+count(N + 1); !go. +!go."


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=5)
    repeat = parser.parse_args().repeat
    sets = learn_all()
    for name, model in (("table", TABLE), ("spinning", SPINNING)):
        for engine in ENGINES:
            system = MultiAgentSystem.load(model, engine=engine)
            show(f"{name}, {engine}", median_s(partial(run, system, FOUR_LEGS), 200 * repeat))
        memo(name, model, sets, repeat)
    show("learning", learning(repeat))
    linear(repeat)


def memo(name: str, model: Path, sets: list[tuple[str, ...]], repeat: int) -> None:
    """The mean of these runs, on a memo that knows nothing yet, and again when it knows them all."""
    cold: list[float] = []
    warm: list[float] = []
    for _ in range(repeat):
        system = MultiAgentSystem.load(model, engine="memo")
        for times in (cold, warm):
            times.append(median_s(partial(run_all, system, sets), 1) / len(sets))
    show(f"{name}, memo, cold", statistics.median(cold))
    show(f"{name}, memo, warm", statistics.median(warm))


def learning(repeat: int) -> float:
    """1,000 iterations of Q-learning in a new process, everything included."""
    command = [sys.executable, "-c", LEARNING]
    done = (subprocess.run(command, capture_output=True, text=True, check=True) for _ in range(repeat))
    return statistics.median(float(each.stdout) for each in done)


def linear(repeat: int) -> None:
    """The cost of an agent's reasoning cycle, whatever the length of the run and the number of agents."""
    for rounds, agents in COUNTS:
        for engine in ENGINES:
            with tempfile.TemporaryDirectory() as folder:
                system = counters(Path(folder), rounds, agents, engine)
                took = median_s(partial(system.run, max_rounds=rounds), min(repeat, 3))
            show(f"{rounds} rounds, {agents} agents, {engine}", took / rounds / agents)


def counters(folder: Path, rounds: int, agents: int, engine: Engine) -> MultiAgentSystem:
    """A system of agents that count as long as the run lasts."""
    (folder / "counter.asl").write_text(COUNTER.format(rounds=rounds), encoding="utf-8")
    (folder / "counters.mas2j").write_text(f"MAS counters {{ agents: counter #{agents}; }}", encoding="utf-8")
    return MultiAgentSystem.load(folder / "counters.mas2j", Environment(), engine)


class Log:
    """Explores, and keeps the subsets that it is asked for."""

    def __init__(self, runner: ModelRunner) -> None:
        self._runner = runner
        self.subsets: list[tuple[str, ...]] = []

    def run(self, beliefs: Iterable[str]) -> ModelRun:
        """Run one subset."""
        run = self._runner.run(beliefs)
        self.subsets.append(run.beliefs)
        return run


def learn_all() -> list[tuple[str, ...]]:
    """Learn for 1,000 iterations; the subsets that were run, about 6,500, in order."""
    log = Log(ModelRunner(Model(TABLE), SPACE))
    learn(log, SPACE, QLearning(stop_when_converged=False), seed=0)
    return log.subsets


def run(system: MultiAgentSystem, beliefs: tuple[str, ...]) -> None:
    """One run of the table model."""
    system.run(percepts={"meta": [f"chosen({belief})" for belief in beliefs]})


def run_all(system: MultiAgentSystem, sets: list[tuple[str, ...]]) -> None:
    """A run for every set of beliefs."""
    for beliefs in sets:
        run(system, beliefs)


def median_s(action: Callable[[], object], count: int) -> float:
    """The median wall time of an action."""
    times = []
    for _ in range(count):
        began = time.perf_counter()
        action()
        times.append(time.perf_counter() - began)
    return statistics.median(times)


def show(name: str, seconds: float) -> None:
    """Print a time."""
    print(f"{name}\t{seconds!r}", flush=True)


if __name__ == "__main__":
    main()
