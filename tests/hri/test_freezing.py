"""Freezing when calm changes no verdict, leg or message: over parts of each suite, and over a whole one (slow)."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from itertools import islice

import pytest

from pytest_hricdv.case import CaseResult
from pytest_hricdv.generate.concrete import ConcreteTest
from sim.workshop import Workshop
from tests.hri import bench

SUITES = ("rl", "by-hand", "bdi-random", "pseudorandom")
EACH = 5


def assert_equal(tests: Iterable[ConcreteTest], monkeypatch: pytest.MonkeyPatch) -> None:
    """Each run, with freezing and without, tells the same."""
    for test in tests:
        frozen = bench.run(test)
        with monkeypatch.context() as patch:
            patch.setattr("sim.workshop.Workshop", partial(Workshop, freeze=False))
            stepped = bench.run(test)
        assert stepped.outcome.skipped_s == 0.0
        assert told(stepped) == told(frozen), test.id


def told(result: CaseResult) -> tuple[object, ...]:
    """Messages with their times, legs, why it ended, and each requirement's verdict and number of attempts."""
    verdicts = [(each.requirement, each.verdict, each.attempts, each.failures) for each in result.verdicts]
    messages = [str(message) for message in result.record.messages]
    return messages, verdicts, result.outcome.outcomes, result.outcome.ended, result.sim_s


@pytest.mark.parametrize("name", SUITES)
def test_a_suite_tells_the_same_with_freezing_and_without(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert_equal(islice(bench.suite(name), EACH), monkeypatch)


@pytest.mark.slow
def test_the_whole_learned_suite_tells_the_same_with_freezing_and_without(monkeypatch: pytest.MonkeyPatch) -> None:
    assert_equal(bench.suite("rl"), monkeypatch)
