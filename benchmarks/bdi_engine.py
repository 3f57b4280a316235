"""How fast the BDI agents run, and that the cost of a reasoning cycle is constant. Prints medians of CPU times.

    python -m benchmarks.bdi_engine [--repeat N]

It prints, for the table model and for the same task with agents that wait busily: one run without the memo, and the
mean of the runs of learning on an empty memo. Then one reasoning cycle of an agent that counts, for runs of
several lengths and numbers of agents. `python -m benchmarks.generation` measures the generation of a suite.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

from pytest_hricdv.bdi import MultiAgentSystem
from pytest_hricdv.bdi.memo import Memo
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.learner import learn
from pytest_hricdv.generate.model import Model, ModelRun
from pytest_hricdv.generate.model_runner import ModelRunner
from pytest_hricdv.generate.qlearning import QLearning
from studies.session import machine

ROOT = Path(__file__).parents[1]
TABLE = ROOT / "models_bdi" / "table_assembly.mas2j"
SPINNING = ROOT / "benchmarks" / "spinning" / "spinning.mas2j"
MODELS = {"the table model": TABLE, "the same task by agents that wait busily": SPINNING}
FOUR_LEGS = ("leg1", "m111l1", "m111l2", "m111l3", "m111l4")
SPACE = BeliefSpace(
    start=("leg1", "leg2", "leg3", "leg4"),
    groups={
        "boredom": ("bored", "not_bored"),
        **{f"pose{leg}": tuple(f"m{pose:03b}l{leg}" for pose in range(8)) for leg in range(1, 5)},
    },
    default_beliefs=("not_bored",),
)
PEERS = """  for comparison, with the original models of the same task, not measured here:
  python-agentspeak 0.2.2                          5.0    ms
  Jason 1.4.2, in a warm JVM                      64      ms
  Jason 1.4.2, from process start to last line   810      ms"""
COUNTS = ((1_000, 1), (10_000, 1), (1_000, 10), (1_000, 100))
"""Rounds and agents that count."""
COUNTER = "count(0). !go. +!go : count(N) & N < {rounds} <- -+count(N + 1); !go. +!go."


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeat", type=int, default=5, metavar="N", help="runs of each measurement (default 5)")
    repeat = parser.parse_args().repeat
    print(f"machine: {machine()}\nmedians of {repeat} CPU times, of {40 * repeat} for a single run\n", flush=True)
    sets = learned_sets()
    for name, model in MODELS.items():
        print(name)
        system = MultiAgentSystem.load(model)
        show("  a run with four legs, without the memo", median_s(partial(run, system, FOUR_LEGS), 40 * repeat), "ms")
        cold = [median_s(partial(run_all, Memo(MultiAgentSystem.load(model)), sets), 1) for _ in range(repeat)]
        show(f"  mean of the {len(sets)} runs of learning, with the memo", statistics.median(cold) / len(sets), "ms")
        if model == TABLE:
            print(PEERS)
    print("a reasoning cycle of an agent that counts")
    for rounds, agents in COUNTS:
        show(f"  {rounds} rounds, {agents} agents", cycle(rounds, agents, min(repeat, 3)), "us")


def cycle(rounds: int, agents: int, repeat: int) -> float:
    """Seconds of one reasoning cycle of agents that count as long as the run lasts."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "counter.asl").write_text(COUNTER.format(rounds=rounds), encoding="utf-8")
        (folder / "counters.mas2j").write_text(f"MAS counters {{ agents: counter #{agents}; }}", encoding="utf-8")
        system = MultiAgentSystem.load(folder / "counters.mas2j")
    return median_s(partial(system.run, max_rounds=rounds), repeat) / rounds / agents


class Log:
    """Runs the model, and keeps the subsets that it is asked for."""

    def __init__(self, runner: ModelRunner) -> None:
        self._runner = runner
        self.subsets: list[tuple[str, ...]] = []

    def run(self, beliefs: Iterable[str]) -> ModelRun:
        """Run one subset."""
        run = self._runner.run(beliefs)
        self.subsets.append(run.beliefs)
        return run


def learned_sets() -> list[tuple[str, ...]]:
    """Learn for 1,000 iterations; the subsets that were run, about 6,500, in order."""
    log = Log(ModelRunner(Model(TABLE), SPACE))
    learn(log, SPACE, QLearning(stop_when_converged=False), seed=0)
    return log.subsets


def run(system: MultiAgentSystem | Memo, beliefs: tuple[str, ...]) -> None:
    """One run of a model."""
    system.run(percepts={"meta": [f"chosen({belief})" for belief in beliefs]})


def run_all(memo: Memo, sets: list[tuple[str, ...]]) -> None:
    """A run for every set of beliefs."""
    for beliefs in sets:
        run(memo, beliefs)


def median_s(action: Callable[[], object], count: int) -> float:
    """The median CPU time of an action."""
    times = []
    for _ in range(count):
        began = time.process_time()
        action()
        times.append(time.process_time() - began)
    return statistics.median(times)


def show(label: str, seconds: float, unit: str) -> None:
    """Print a time."""
    factor = {"s ": 1.0, "ms": 1e3, "us": 1e6}[unit]
    print(f"{label:62}{seconds * factor:10.4f} {unit}", flush=True)


if __name__ == "__main__":
    main()
