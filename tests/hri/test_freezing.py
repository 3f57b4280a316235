"""Freezing (no physics steps while nothing moves) changes no message and no verdict, in tests of every suite."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from itertools import islice

import pytest

from pytest_hricdv.execution.case import CaseResult
from pytest_hricdv.generate.concrete import ConcreteTest
from sim.workshop import Workshop
from tests.hri import bench

SUITES = ("rl", "by-hand", "bdi-random", "pseudorandom")
STRIDE = 36
"""The first test of each suite and each so many that follow are run twice."""


def assert_equal(tests: Iterable[ConcreteTest], monkeypatch: pytest.MonkeyPatch) -> None:
    """Each run has the same messages and verdicts with freezing and without."""
    for test in tests:
        frozen = bench.run(test)
        assert frozen.outcome.skipped_s > 0.0
        with monkeypatch.context() as patch:
            patch.setattr("sim.workshop.Workshop", partial(Workshop, freeze=False))
            stepped = bench.run(test)
        assert stepped.outcome.skipped_s == 0.0
        assert observed(stepped) == observed(frozen), test.id


def observed(result: CaseResult) -> tuple[object, ...]:
    """Messages with their times, outcomes, end of the run, and each requirement's verdict and number of triggers."""
    verdicts = [(each.requirement, each.verdict, each.triggers, each.failures) for each in result.verdicts]
    messages = [str(message) for message in result.record.messages]
    return messages, verdicts, result.outcome.outcomes, result.outcome.ended, result.sim_s


@pytest.mark.slow
@pytest.mark.parametrize("name", SUITES)
def test_freezing_changes_no_message_and_no_verdict(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert_equal(islice(bench.suite(name), 0, None, STRIDE), monkeypatch)
