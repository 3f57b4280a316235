"""Messages that are lost, late or doubled: the robot copes, and neither requirements nor the model's agent complain."""

from __future__ import annotations

from dataclasses import replace

import pytest

from pytest_hricdv.disturbance import MessageDisturbance
from pytest_hricdv.execution.case import CaseResult, RunSettings, execute, feature_criteria
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import concretize
from pytest_hricdv.testbench import Constant, Delay, Disturbance, Drop, Duplicate

from . import bench
from .disturbed import concrete, judged, unknown_violations


def disturbed(disturbance: MessageDisturbance, *further: str) -> CaseResult:
    """A run in which this happens to the first message of its kind, with all requirements and the model's agent.

    Args:
        disturbance: to be applied at once.
        further: commands after the first two legs.
    """
    disturbances: dict[str, Disturbance | MessageDisturbance] = {"it": disturbance}
    testbench = replace(bench.testbench(), disturbances=disturbances)
    lines = ("disturb it", *bench.leg(), *bench.leg("110"), *further)
    abstract = AbstractTest("test", "tests", "a test", (), lines, seed=3)
    test = bench.forcing(concretize(abstract, testbench.commands), {"grip_s": 0.0, "outage_turn": 0.0})
    criteria = (*bench.requirements(), *feature_criteria(testbench))
    return execute(RunSettings(testbench, criteria), test)


@pytest.mark.parametrize(
    ("disturbance", "outcomes"),
    [
        (Drop("request"), ("discarded",)),
        (Drop("human_ready"), ("no-human-ready", "discarded")),
        (Drop("leg_ready"), ("no-human-ready", "discarded")),
        (Delay("human_ready", Constant(4.0)), ("released", "discarded")),
        (Duplicate("request", Constant(4.0)), ("released", "discarded")),
    ],
    ids=str,
)
def test_the_turn_goes_on_as_if_it_had_been_said_when_it_was_heard(
    disturbance: MessageDisturbance, outcomes: tuple[str, ...]
) -> None:
    result = disturbed(disturbance)
    assert result.outcome.outcomes == outcomes
    assert not result.failed
    assert not result.errors


def test_a_person_who_does_not_hear_that_the_turn_is_over_takes_the_leg_away() -> None:
    """Who stood there with it for 150 s was hit by the next leg, with more than 0.25 rad/s in the arm (R4)."""
    *answered, ready = bench.leg()
    again = ("asks_again", {"after_s": 31.3})
    result = judged(concrete([*answered, "disturb end_lost", ready, again], sensing_timeout_s=30.0))
    assert result.outcome.outcomes[0] == "released"
    times_s, values = result.record.signals["leg_taken"]
    (taken_s, put_down_s) = (time_s for time_s, value in zip(times_s, values, strict=True) if time_s)
    assert 15.0 < put_down_s - taken_s < 20.0
    assert len(result.outcome.outcomes) == 2
    assert not unknown_violations(result)
