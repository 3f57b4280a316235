"""A run: its actions, those of its test or produced one by one while it goes on, and when it ends."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import pytest

from pytest_hricdv.disturbance import Disturbance
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest
from pytest_hricdv.generate.sampler import Uniform
from pytest_hricdv.monitor import MonitorSet, Requirement, Vocabulary, parse_formula
from pytest_hricdv.run import Actions
from pytest_hricdv.runtime import Bus, Kernel, Recorder
from pytest_hricdv.testbench import Run

WAVE, NOD, BOW = (
    ConcreteAction(command, {"takes_s": takes_s})
    for command, takes_s in zip(("wave", "nod", "bow"), (2.0, 3.0, 4.0), strict=True)
)
TEST = ConcreteTest("t", "s", 0, (WAVE, NOD, BOW))


def make_run(test: ConcreteTest, producing: Actions | None = None) -> Run:
    kernel, recorder = Kernel(), Recorder()
    bus = Bus(kernel, (), recorder)
    return Run(test, kernel, bus, recorder, lambda body: body, MonitorSet([]), producing=producing)


REQUIREMENT = "always(on(ask) -> eventually[0:5](on(answer)))"


@dataclass(frozen=True)
class Ask:
    """Somebody asks."""


@dataclass(frozen=True)
class Answer:
    """Somebody answers."""


def asking(period_s: float, requirement: str = REQUIREMENT, answers_s: tuple[float, ...] = ()) -> Run:
    """A run in which somebody asks all the time, from the first period on, and is answered at these times."""
    formula = parse_formula(requirement, Vocabulary(messages={"ask": {}, "answer": {}}))
    monitors = MonitorSet([Requirement("R1", "An answer", "", requirement, formula)])
    kernel, recorder = Kernel(), Recorder()
    recorder.listeners.append(monitors)
    run = Run(TEST, kernel, Bus(kernel, (Ask, Answer), recorder), recorder, lambda body: body, monitors)

    def ask() -> None:
        while True:
            kernel.sleep(period_s)
            run.bus.publish("visitor", Ask())

    def answer() -> None:
        for time_s in answers_s:
            kernel.sleep(time_s - kernel.now_s)
            run.bus.publish("robot", Answer())

    kernel.spawn("visitor", ask)
    kernel.spawn("robot", answer)
    return run


@pytest.mark.parametrize(
    ("requirement", "ends_s"),
    [
        (REQUIREMENT, 65.0),
        ("always(on(ask) -> eventually[2:5](on(answer)))", 65.0),
        ("always(once[0:1](on(ask)) -> eventually[0:5](on(answer)))", 60.0),  # triggered once, and decided long ago
        ("always(on(ask) -> always[0:5](!on(answer)))", 60.0),  # kept so far: nothing is waited for
        ("always(on(ask) -> eventually[0:0.05](on(answer)))", 60.0),  # triggered at the last instant: pending
        ("always(on(ask) -> eventually[0:0.95](on(answer)))", 60.95),
    ],
)
def test_a_run_ends_at_its_limit_and_the_last_deadline_open_then(requirement: str, ends_s: float) -> None:
    run = asking(0.1, requirement)
    assert run.go(60.0) == "limit"
    assert run.kernel.now_s == pytest.approx(ends_s, abs=1e-5)


def test_what_is_triggered_after_the_limit_is_pending_and_decides_nothing() -> None:
    run = asking(1.0)
    run.go(10.0)
    (verdict,) = run.monitors.finish(run.kernel.now_s)
    assert run.kernel.now_s == 15.0
    assert (verdict.triggers, verdict.failures, verdict.pending) == (15, 10, 5)


def test_a_run_that_is_stopped_goes_on_as_far_though_it_is_stopped_again() -> None:
    run = asking(0.5)

    def stop() -> None:
        while True:
            run.kernel.sleep(1.75)
            run.kernel.stop("over")

    run.kernel.spawn("stopping", stop)
    assert run.go(60.0) == "over"
    assert run.kernel.now_s == 1.5 + 5.0


def enact(run: Run, ends_s: float = 100.0) -> None:
    """Let a person take one action after the other."""

    def person() -> None:
        for action in run.actions():
            run.kernel.sleep(action.parameters["takes_s"])

    run.kernel.spawn("person", person)
    run.go(ends_s)


def test_actions_are_those_of_the_test_and_begin_when_they_are_taken() -> None:
    run = make_run(TEST)
    assert run.taken == []
    enact(run)
    assert run.taken == [WAVE, NOD, BOW]
    assert run.action_times_s == [0.0, 2.0, 5.0]
    assert run.enacted == TEST


def test_a_world_that_has_the_whole_test_reports_what_begins() -> None:
    run = make_run(TEST)
    for number in (0, 0, 1, 7):
        run.report_action(number)
    assert run.taken == [WAVE, NOD]
    assert run.action_times_s == [0.0, 0.0]


def test_a_disturbance_is_taken_when_the_person_comes_to_it_and_nobody_enacts_it() -> None:
    applied: list[tuple[float, float]] = []
    slip = Disturbance(
        {"by_m": Uniform(0.0, 1.0)}, lambda world, given: world.append((run.kernel.now_s, given["by_m"]))
    )
    test = replace(TEST, actions=(WAVE, ConcreteAction("disturb slip", {"by_m": 0.5}), NOD))
    run = make_run(replace(test, actions=()), lambda run, actor: iter(test.actions))
    run.disturbances = {"slip": slip}
    run.set_disturbance_target(applied)
    enact(run)
    assert applied == [(2.0, 0.5)]
    assert run.action_times_s == [0.0, 2.0, 2.0]
    assert run.kernel.now_s == 5.0
    assert run.enacted == test


def test_produced_actions_are_produced_when_the_person_is_free() -> None:
    asked_s = []

    def producing(run: Run, actor: str) -> Iterator[ConcreteAction]:
        while run.kernel.now_s < 7.0:
            asked_s.append(run.kernel.now_s)
            yield NOD if run.taken else BOW

    run = make_run(replace(TEST, actions=()), producing)
    enact(run)
    assert run.taken == [BOW, NOD]
    assert asked_s == run.action_times_s == [0.0, 4.0]
    assert run.enacted == replace(TEST, actions=(BOW, NOD))
