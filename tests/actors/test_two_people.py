"""A fault that takes two people: found, shrunk to two actions, replayed; each person alone is harmless."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from pytest_hricdv.execution.case import CaseResult, RunSettings, execute
from pytest_hricdv.experiments.budget import Budget
from pytest_hricdv.experiments.shrink import shrink
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import ConcreteTest, abstract_from, concretize
from pytest_hricdv.generate.context import GenerationContext
from pytest_hricdv.generate.methods import METHODS
from pytest_hricdv.monitor import Requirement, load_requirements
from pytest_hricdv.testbench import Testbench
from pytest_hricdv.testbench_faults import check_testbench
from tests.actors.corridor.bench import ward


@cache
def bench(obeys: bool = True) -> Testbench:
    return check_testbench(ward(obeys=obeys), "tests")


@cache
def requirements() -> tuple[Requirement, ...]:
    return load_requirements(bench().requirements, bench().vocabulary())


def suite(method: str, tests: int, seed: int = 0) -> Sequence[AbstractTest]:
    commands = tuple(bench().concretization.commands)
    context = GenerationContext(
        bench().model, bench().beliefs, commands, seed, tests, bench().suites.by_hand, lengths=(2, 4)
    )
    return METHODS[method].generate(context).tests


def run(test: ConcreteTest, testbench: Testbench | None = None) -> CaseResult:
    return execute(RunSettings(testbench or bench(), requirements()), test)


@cache
def found() -> ConcreteTest:
    """The first pseudorandom test that fails R1."""
    tests = (concretize(test, bench().commands) for test in suite("pseudorandom", 30))
    return next(test for test in tests if "R1" in run(test).failed)


def test_the_fault_is_found_and_shrunk_to_an_action_of_each() -> None:
    shrunk = shrink(found(), bench().commands, lambda test: "R1" in run(test).failed, Budget(200, 600.0)).test
    assert sorted(action.command for action in shrunk.actions) == ["child: step_in", "nurse: send_on"]
    assert run(shrunk).failed == ("R1",)


def test_without_the_fault_nothing_fails() -> None:
    assert run(found(), bench(obeys=False)).failed == ()


def test_a_run_is_the_same_again_also_from_its_stored_test() -> None:
    first = run(found())
    stored = abstract_from(first.test, "again", keeps_id=True)
    again = run(concretize(stored, bench().commands))
    assert again.record.sha256 == first.record.sha256
    assert again.begun == first.begun


def test_model_based_tests_say_what_the_model_makes_wait() -> None:
    ordered = {test.beliefs: test for test in suite("bdi-random", 6)}
    looked_after = ordered["playful", "watchful"]
    effects = {
        looked_after.lines[number - 1]: [looked_after.lines[cause - 1] for cause in causes]
        for number, causes in looked_after.after.items()
    }
    assert effects == {"child: step_out": ["nurse: call_out"]}
    assert ordered["playful", "hurried"].after == {}
    result = run(concretize(looked_after, bench().commands))
    began = dict(zip([looked_after.lines[n] for n in result.begun], result.action_times_s, strict=True))
    assert began["child: step_out"] > began["nurse: call_out"]
    assert looked_after.plans == {"child": ("listens", "playful"), "nurse": ("watchful",)}


def test_the_same_seed_gives_the_same_tests() -> None:
    assert suite("rl", 8) == suite("rl", 8)
    assert {test.beliefs for test in suite("by-hand", 3)} <= {
        ("shy", "hurried"),
        ("playful", "hurried"),
        ("playful", "watchful"),
    }
