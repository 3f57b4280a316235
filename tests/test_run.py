"""The actions of a run: those of its test, or produced one by one while it goes on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from pytest_hricdv.disturbance import Disturbance
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest
from pytest_hricdv.generate.sampler import Range
from pytest_hricdv.monitor import MonitorSet
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
    assert run.acted_s == [0.0, 2.0, 5.0]
    assert run.enacted == TEST


def test_a_run_that_is_over_early_is_still_one_of_the_whole_test() -> None:
    run = make_run(TEST)
    enact(run, ends_s=3.0)
    assert run.taken == [WAVE, NOD]
    assert run.enacted == TEST


def test_a_world_that_has_the_whole_test_reports_what_begins() -> None:
    run = make_run(TEST)
    for number in (0, 0, 1, 7):
        run.acting(number)
    assert run.taken == [WAVE, NOD]
    assert run.acted_s == [0.0, 0.0]


def test_a_disturbance_is_taken_when_the_person_comes_to_it_and_nobody_enacts_it() -> None:
    applied: list[tuple[float, float]] = []
    slip = Disturbance({"by_m": Range(0.0, 1.0)}, lambda world, given: world.append((run.kernel.now_s, given["by_m"])))
    test = replace(TEST, actions=(WAVE, ConcreteAction("disturb slip", {"by_m": 0.5}), NOD))
    run = make_run(replace(test, actions=()), lambda run: iter(test.actions))
    run.disturbances = {"slip": slip}
    run.disturbs(applied)
    enact(run)
    assert applied == [(2.0, 0.5)]
    assert run.acted_s == [0.0, 2.0, 2.0]
    assert run.kernel.now_s == 5.0
    assert run.enacted == test


def test_produced_actions_are_produced_when_the_person_is_free() -> None:
    asked_s = []

    def producing(run: Run) -> Iterator[ConcreteAction]:
        while run.kernel.now_s < 7.0:
            asked_s.append(run.kernel.now_s)
            yield NOD if run.taken else BOW

    run = make_run(replace(TEST, actions=()), producing)
    enact(run)
    assert run.taken == [BOW, NOD]
    assert asked_s == run.acted_s == [0.0, 4.0]
    assert run.enacted == replace(TEST, actions=(BOW, NOD))
