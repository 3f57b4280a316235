"""A fault of coroutines that takes two of three people in two of six orders; and who only tells others something."""

from __future__ import annotations

from functools import cache
from itertools import combinations, pairwise

import pytest

from pytest_hricdv.execution.case import CaseResult, RunSettings, execute
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.actors import actor_of
from pytest_hricdv.generate.concrete import concretize
from pytest_hricdv.monitor import load_requirements
from pytest_hricdv.testbench import Testbench
from pytest_hricdv.testbench_faults import check_testbench
from tests.actors.hospital.bench import hospital

LINES = ("nurse: load", "nurse: send", "porter: open", "porter: close")
FATAL = (
    ("porter: open", "nurse: load", "nurse: send", "porter: close"),
    ("porter: open", "nurse: load", "porter: close", "nurse: send"),
)
"""It is loaded while the door is open, which is closed before it is there."""


@cache
def bench(looks_late: bool = False, online: bool = False) -> Testbench:
    return check_testbench(hospital(looks_late, online), "tests")


def run(test: AbstractTest, testbench: Testbench) -> CaseResult:
    settings = RunSettings(testbench, load_requirements(testbench.requirements, testbench.vocabulary()))
    return execute(settings, concretize(test, testbench.commands))


def interleaved(order: tuple[str, ...]) -> AbstractTest:
    """The test with these lines one after the other, each of which takes two seconds."""
    after = {
        number + 1: (number,)
        for number, (line, following) in enumerate(pairwise(order), 1)
        if actor_of(line) != actor_of(following)
    }
    takes = {number: {"takes_s": 2.0} for number in range(1, 5)}
    return AbstractTest("t", "s", "t", (), order, seed=1, values=takes, after=after)


def orders() -> list[tuple[str, ...]]:
    """All orders that keep both lanes."""
    found = []
    for places in combinations(range(4), 2):
        nurse, porter = iter(LINES[:2]), iter(LINES[2:])
        found.append(tuple(next(nurse) if place in places else next(porter) for place in range(4)))
    return found


@pytest.mark.parametrize("order", orders())
def test_two_orders_of_six_are_fatal(order: tuple[str, ...]) -> None:
    result = run(interleaved(order), bench())
    assert result.begun == (0, 1, 2, 3)
    assert result.failed == (("R1",) if order in FATAL else ())


def test_without_the_fault_or_one_of_them_nothing_fails() -> None:
    assert run(interleaved(FATAL[1]), bench(looks_late=True)).failed == ()
    for actor in ("nurse", "porter"):
        alone = tuple(line for line in LINES if actor_of(line) == actor)
        assert run(AbstractTest("t", "s", "t", (), alone, seed=1), bench()).failed == ()
