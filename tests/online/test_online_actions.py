"""Actions of a run that are produced by an agent: the person waits first, and time passes for the agent last."""

from __future__ import annotations

from pathlib import Path

from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import ConcreteTest, Concretization, concretize
from pytest_hricdv.generate.sampler import Constant, Uniform
from pytest_hricdv.monitor import MonitorSet
from pytest_hricdv.online.online_agent import OnlineActions
from pytest_hricdv.run import Run
from pytest_hricdv.runtime import Bus, Kernel, Recorder
from tests.online.toy import Life, Wish, role

COMMANDS = Concretization({name: {"takes_s": Constant(2.0, "s")} for name in ("press", "refuse", "leave")})
REFUSES = "@a +!fetch <- press; .wait(20000); leave. +cup(Size) <- -cup(Size)[source(robot)]; refuse."


def run_of(kernel: Kernel) -> Run:
    """A run without a world, a robot or requirements."""
    test, recorder = ConcreteTest("toy", "toys", 3, ()), Recorder()
    return Run(test, kernel, Bus(kernel, (), recorder), recorder, lambda body: body, MonitorSet())


def produced(folder: Path, offers_s: list[float], waits: bool = True) -> list[tuple[float, str]]:
    """When the person does what; cups are offered at these times, and the person waits up to 5 s for the next."""
    kernel, life = Kernel(), Life(role(folder, REFUSES), Wish())
    run = run_of(kernel)
    done: list[tuple[float, str]] = []

    def act() -> None:
        for action in OnlineActions(life.agent, COMMANDS)(run):
            done.append((round(kernel.now_s, 1), action.command))
            kernel.sleep(action.parameters["takes_s"])

    def offer() -> None:
        for time_s in offers_s:
            kernel.sleep(time_s - kernel.now_s)
            life.agent.message(kernel.now_s, "offer", {"size": "small"})

    if waits:
        run.set_idle_handler(lambda: kernel.sleep(5.0))
    kernel.spawn("person", act)
    kernel.spawn("offers", offer)
    run.go(100.0)
    return done


def test_what_is_heard_while_the_person_waits_comes_before_the_agents_own_time(tmp_path: Path) -> None:
    assert produced(tmp_path, [4.0, 10.0]) == [(0.0, "press"), (7.0, "refuse"), (14.0, "refuse"), (21.0, "leave")]


def test_without_waiting_only_what_was_heard_by_then_counts(tmp_path: Path) -> None:
    assert produced(tmp_path, [3.0, 5.0], waits=False) == [
        (0.0, "press"),
        (2.0, "leave"),
        (4.0, "refuse"),
        (6.0, "refuse"),
    ]


def test_parameters_are_drawn_as_those_of_the_test_with_the_same_seed(tmp_path: Path) -> None:
    commands = Concretization({name: {"takes_s": Uniform(1.0, 2.0, "s")} for name in ("press", "wave")})
    agent = Life(role(tmp_path, "@a +!fetch <- press; wave."), Wish()).agent
    actions = tuple(OnlineActions(agent, commands)(run_of(Kernel())))
    assert actions == concretize(AbstractTest("toy", "toys", "a toy", (), ("press", "wave"), seed=3), commands).actions
