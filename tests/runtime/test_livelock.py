"""Runs that go round are ended, and named; runs that wait, or in which something is new, are not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import pytest

from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest
from pytest_hricdv.monitor import MonitorSet
from pytest_hricdv.run import Run
from pytest_hricdv.runtime import Bus, Kernel, KernelError, Recorder

LIMIT_S = 10_000.0
ENDS_BY_S = 300.0


@dataclass(frozen=True)
class State:
    """What the robot does."""

    name: str


@dataclass(frozen=True)
class Reading:
    """What a sensor says (m)."""

    distance_m: float
    is_near: bool


class Robot:
    """A run with a robot, whose code it is, and others."""

    def __init__(self) -> None:
        kernel, recorder = Kernel(), Recorder()
        bus = Bus(kernel, (State, Reading), recorder, lambda: kernel.own_node() in self.code)
        actions = tuple(ConcreteAction("wave", {}) for _ in range(20))
        test = ConcreteTest("t", "s", 0, actions)
        self.run = Run(test, kernel, bus, recorder, lambda body: body, MonitorSet([]), may_go_round=False)
        self.kernel = kernel
        self.code: list[object] = []

    def says(self, *states: str, each_s: float) -> None:
        """The robot is in these states in turn."""

        def body() -> None:
            while True:
                for state in states:
                    self.run.bus.publish("robot", State(state))
                    self.kernel.sleep(each_s)

        self.code.append(self.kernel.spawn("robot", body))

    def senses(self, period_s: float) -> None:
        """A sensor sends readings."""

        def body() -> None:
            while True:
                self.kernel.sleep(period_s)
                self.run.bus.publish("sensor", Reading(self.kernel.now_s % 0.37, is_near=False))

        self.kernel.spawn("sensor", body)

    def other(self, body: Callable[[], None]) -> None:
        """Somebody else does something."""
        self.kernel.spawn("other", body)

    def every(self, period_s: float, act: Callable[[], object]) -> None:
        """Something happens again and again."""

        def body() -> None:
            while True:
                self.kernel.sleep(period_s)
                act()

        self.other(body)


def announcing(robot: Robot) -> None:
    robot.says("Send", "Receive", each_s=15.0)


def sensing(robot: Robot) -> None:
    robot.says("Sense", "Decide", each_s=0.01)
    robot.senses(0.02)


def left_open(robot: Robot) -> None:
    robot.senses(0.02)


def numbered(robot: Robot) -> None:
    robot.every(0.5, lambda: robot.run.bus.publish("clock", State(f"tick {robot.kernel.now_us}")))


def with_noise(robot: Robot) -> None:
    sensing(robot)
    robot.every(0.1, lambda: robot.run.recorder.signal(robot.kernel.now_s, "x_m", robot.kernel.now_s % 0.7))


def with_a_timer_of_its_own(robot: Robot) -> None:
    sensing(robot)
    robot.other(lambda: robot.kernel.sleep(5000.0))


@pytest.mark.parametrize("begin", [announcing, sensing, left_open, numbered, with_noise, with_a_timer_of_its_own])
def test_a_run_that_goes_round_is_ended_and_named(begin: Callable[[Robot], None]) -> None:
    robot = Robot()
    begin(robot)
    assert robot.run.go(LIMIT_S) == "goes round"
    ending = robot.run.ending
    assert ending is not None
    assert ending.how == "cycle"
    assert ending.cycle is not None
    assert ending.time_s < ENDS_BY_S
    assert ending.cycle.times >= 5


def waiting(robot: Robot) -> None:
    """It says so all the time, and nobody says anything to it: who knows who will come."""
    robot.says("Waiting", each_s=0.1)


def with_a_person(robot: Robot) -> None:
    announcing(robot)
    actions = robot.run.actions()
    robot.every(150.0, lambda: next(actions, None))


def that_moves(robot: Robot) -> None:
    sensing(robot)
    robot.every(1.0, lambda: robot.run.recorder.signal(robot.kernel.now_s, "way_m", robot.kernel.now_s))


def that_says_new_things(robot: Robot) -> None:
    sensing(robot)
    robot.every(100.0, lambda: robot.run.bus.publish("log", State("x" * int(robot.kernel.now_s / 100))))


def that_has_new_texts(robot: Robot) -> None:
    sensing(robot)
    robot.every(
        100.0,
        lambda: robot.run.recorder.signal(robot.kernel.now_s, "mode", "x" * int(robot.kernel.now_s / 100)),
    )


@pytest.mark.slow
@pytest.mark.parametrize("begin", [waiting, with_a_person, that_moves, that_says_new_things, that_has_new_texts])
def test_a_run_in_which_something_is_new_or_may_come_goes_on(begin: Callable[[Robot], None]) -> None:
    robot = Robot()
    begin(robot)
    assert robot.run.go(1200.0) == "limit"


def test_a_run_that_may_go_round_does() -> None:
    robot = Robot()
    announcing(robot)
    robot.run.may_go_round = True
    assert robot.run.go(1200.0) == "limit"
    assert robot.run.ending is not None
    assert robot.run.ending.cycle is None


def test_time_passes_in_a_loop_that_only_polls_where_polls_take_some() -> None:
    kernel = Kernel()
    kernel.polls_take_s = 0.01

    def waits_for_a_second() -> None:
        while kernel.now_s < 1.0:
            kernel.count_poll()

    kernel.spawn("busy", waits_for_a_second)
    kernel.run(10.0)
    assert kernel.now_s == pytest.approx(1.0, abs=0.02)


def test_time_passes_in_a_loop_that_waits_for_a_clock_and_others_go_on_meanwhile() -> None:
    kernel = Kernel()
    ticks: list[float] = []

    def waits_for_a_second() -> None:
        while kernel.now_s < 1.0:
            kernel.count_clock_read()

    def ticking() -> None:
        for _ in range(3):
            kernel.sleep(0.25)
            ticks.append(kernel.now_s)

    kernel.spawn("busy", waits_for_a_second)
    kernel.spawn("clock", ticking)
    kernel.run(10.0)
    assert kernel.now_s == pytest.approx(1.0, abs=0.002)
    assert ticks == [0.25, 0.5, 0.75]


def test_a_loop_that_looks_for_work_and_reads_no_clock_is_an_error() -> None:
    kernel = Kernel()

    def spins() -> None:
        while True:
            kernel.count_look()

    kernel.spawn("busy", spins)
    with pytest.raises(KernelError, match="polls without time passing"):
        kernel.run(1.0)
