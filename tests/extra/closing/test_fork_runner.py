"""Tests in forks: each does what it does alone, and what goes wrong in one is an error of that one."""

from __future__ import annotations

import contextlib
import os
import signal
from pathlib import Path

import pytest

from pytest_hricdv.extra.closing.process import ForkRunner
from pytest_hricdv.generate.concrete import ConcreteTest
from tests.extra.closing import toy

TESTS = [toy.concrete("ask", "look", "reach"), toy.concrete("sit"), toy.concrete("ask", "look", "reach", seed=2)]


def runner(processes: int = 2, limit_s: float = 30.0) -> ForkRunner[str]:
    """Runs toy tests; the text is what came of one."""
    return ForkRunner(toy.execute, lambda number, result, problem: result or problem, processes, limit_s)


def texts(tests: list[ConcreteTest], processes: int = 2, limit_s: float = 30.0) -> list[str]:
    """What is said of tests, in their order; of each once."""
    said = [*runner(processes, limit_s).run(tests)]
    assert sorted(number for number, _ in said) == [*range(len(tests))]
    return [text for _, text in sorted(said)]


@pytest.mark.parametrize("processes", [1, 2, 3])
def test_each_test_does_what_it_does_alone(processes: int) -> None:
    assert texts(TESTS, processes) == toy.texts(TESTS)


def test_each_test_has_a_process_of_its_own() -> None:
    def parents(number: int, result: str | None, problem: str) -> str:
        return f"{os.getppid()} {os.getpid()}"

    pids = [text.split() for _, text in ForkRunner(toy.execute, parents, 2, 30.0).run(TESTS)]
    assert {parent for parent, _ in pids} == {str(os.getpid())}
    assert len({own for _, own in pids}) == len(TESTS)


@pytest.mark.parametrize(
    ("command", "problem"),
    [
        ("die", "its process: ended by SIGKILL"),
        ("exit", "its process: ended with status 3"),
        ("hang", "its process: no sign of life for 0.3 s"),
        ("spin", "its process: no sign of life for 0.3 s"),
        ("fail", "ValueError: tripped over the cable"),
        ("quit", "SystemExit: "),
    ],
)
def test_what_goes_wrong_in_a_run_is_an_error_of_that_run_only(command: str, problem: str) -> None:
    tests = [toy.concrete("ask", command, "say"), *TESTS]
    assert texts(tests, limit_s=0.3) == [problem, *toy.texts(TESTS)]


def test_a_run_whose_process_was_killed_runs_again(tmp_path: Path) -> None:
    def execute(test: ConcreteTest) -> str:
        with contextlib.suppress(FileExistsError):
            (tmp_path / test.id).touch(exist_ok=False)
            os.kill(os.getpid(), signal.SIGKILL)
        return toy.execute(test)

    said = [*ForkRunner(execute, lambda number, result, problem: result or problem, 1, 30.0).run(TESTS[:1])]
    assert said == [(0, toy.execute(TESTS[0]))]


def test_the_watchdog_of_the_kernel_holds_in_forks_too() -> None:
    def execute(test: ConcreteTest) -> str:
        return toy.execute(test, stuck_after_s=0.1)

    spinning = ForkRunner(execute, lambda number, result, problem: problem, 1, 30.0)
    [(_, problem)] = spinning.run([toy.concrete("ask", "spin")])
    assert "no time has passed for" in problem
