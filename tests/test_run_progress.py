"""A run makes progress: whatever its nodes, its world and its deadlines are, time advances or the run ends."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.monitor import MonitorSet, Requirement, Vocabulary, parse_formula
from pytest_hricdv.runtime import Bus, Kernel, KernelError, Recorder
from pytest_hricdv.testbench import Run


@dataclass(frozen=True)
class Ask:
    """Somebody asks."""


@dataclass(frozen=True)
class Answer:
    """Somebody answers."""


class SteppedWorld:
    """A world of fixed steps, which returns early now and then."""

    def __init__(self, step_us: int) -> None:
        self.now_us = 0
        self.step_us = step_us

    def advance(self, target_us: int) -> int:
        self.now_us = min(self.now_us + self.step_us, target_us)
        return self.now_us

    def observe(self) -> None:
        pass


class CountedKernel(Kernel):
    """Fails when it is run again and again at one instant, with nothing due at it."""

    standstills = 0

    def run(self, limit_s: float) -> str:
        before_us = self.now_us
        why = super().run(limit_s)
        self.standstills = self.standstills + 1 if self.now_us == before_us else 0
        assert self.standstills < 10, f"{why!r} again and again at {self.now_us} us, limit {limit_s!r} s"
        return why


def running(deadline_s: str, step_us: int | None, nodes: list[Callable[[Run], None]]) -> Run:
    text = f"always(on(ask) -> eventually[0:{deadline_s}](on(answer)))"
    formula = parse_formula(text, Vocabulary(messages={"ask": {}, "answer": {}}))
    monitors = MonitorSet([Requirement("R1", "An answer", "", text, formula)])
    kernel, recorder = CountedKernel(), Recorder()
    recorder.listeners.append(monitors)
    kernel.world = None if step_us is None else SteppedWorld(step_us)
    test = ConcreteTest("t", "s", 0, ())
    run = Run(test, kernel, Bus(kernel, (Ask, Answer), recorder), recorder, lambda body: body, monitors)
    for number, node in enumerate(nodes):
        kernel.spawn(f"node {number}", lambda node=node: node(run))  # type: ignore[misc]
    return run


def asking_at(times_us: list[int], *, stops: bool) -> Callable[[Run], None]:
    """A node that asks at these times, stops the run each time if it is to, and then waits for ever."""

    def body(run: Run) -> None:
        for wait_us in times_us:
            run.kernel.sleep(wait_us / 1e6)
            run.bus.publish("visitor", Ask())
            if stops:
                run.kernel.stop("asked")
        run.kernel.block()

    return body


WAITS_US = st.lists(st.integers(1, 40_000_000), max_size=6)
NODES = st.lists(st.builds(lambda waits, stops: asking_at(waits, stops=stops), WAITS_US, st.booleans()), max_size=3)
DEADLINES = st.sampled_from(["0.000001", "0.0000015", "0.05", "0.1", "0.333333333", "2", "7.7", "60"])
STEPS_US = st.none() | st.integers(100_000, 5_000_000)
LIMITS_S = st.integers(0, 60_000_000).map(lambda limit_us: limit_us / 1e6) | st.floats(0, 60)


@given(DEADLINES, STEPS_US, NODES, LIMITS_S)
@example("2", None, [asking_at([12_345_678], stops=False)], 60.0)
@example("0.0000015", None, [asking_at([12_345_678], stops=True)], 60.0)
def test_time_advances_or_the_run_ends(
    deadline_s: str, step_us: int | None, nodes: list[Callable[[Run], None]], limit_s: float
) -> None:
    run = running(deadline_s, step_us, nodes)
    run.go(limit_s)
    (verdict,) = run.monitors.finish(run.kernel.now_s)
    if not nodes:
        assert verdict.triggers == 0
    assert run.kernel.now_s <= max(limit_s, 240.0) + float(deadline_s) + 1e-6


@pytest.mark.parametrize("asked_us", range(12_345_670, 12_345_690))
def test_idle_nodes_without_a_world_let_the_last_deadline_come(asked_us: int) -> None:
    run = running("2", None, [asking_at([asked_us], stops=False)])
    assert run.go(60.0) == "idle"
    assert run.kernel.now_us == asked_us + 2_000_000
    (verdict,) = run.monitors.finish(run.kernel.now_s)
    assert (verdict.triggers, verdict.failures, verdict.pending) == (1, 1, 0)


def test_a_deadline_between_two_microseconds_is_decided() -> None:
    run = running("0.0000015", None, [asking_at([12_345_678], stops=False)])
    run.go(60.0)
    (verdict,) = run.monitors.finish(run.kernel.now_s)
    assert (verdict.failures, verdict.pending) == (1, 0)


@pytest.mark.parametrize("limit_s", [math.inf, -math.inf, math.nan])
def test_a_limit_that_never_comes_is_refused(limit_s: float) -> None:
    with pytest.raises(KernelError, match="expected a finite time"):
        running("2", None, []).go(limit_s)
