"""A controller that raises, never sleeps, or ends early is a fault of its run, with its place."""

from __future__ import annotations

import re

import pytest

from controller import machine
from controller.ports import PlanningError
from controller.robot import Robot
from sim.planner import find_path
from tests.hri import bench

LEG = bench.concrete(bench.leg())


def fails(state: str, body: machine.StateFunction, text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """With this state function the run fails with a text; the next run is unaffected."""
    with monkeypatch.context() as patch:
        patch.setitem(machine.STATES, state, body)
        found = bench.run(LEG)
    (fault,) = found.errors
    assert re.search(text, fault)
    assert found.verdict("R4").verdict == "Passed"  # up to there
    assert bench.run(LEG).outcome.outcomes == ("released",)


def raises(robot: Robot) -> str:
    return dict[str, str]()["missing"]


def polls_for_ever(robot: Robot) -> str:
    while robot.readies.poll() is None:
        pass
    return "ready"


def looks_at_the_clock_for_ever(robot: Robot) -> str:
    until_s = robot.clock.now_s() + 2.0
    while robot.clock.now_s() < until_s:
        pass
    return "settled"


def sleeps_no_time(robot: Robot) -> str:
    while True:
        robot.clock.sleep(0.0)


def computes_for_ever(robot: Robot) -> str:
    while True:
        pass


def test_a_controller_that_raises(monkeypatch: pytest.MonkeyPatch) -> None:
    text = r"the code under test raised KeyError: 'missing' in node robot at \d+\.\d{3} s"
    fails("Decide", raises, text, monkeypatch)


@pytest.mark.parametrize(
    ("state", "body", "text"),
    [
        ("Receive2", polls_for_ever, r"raised KernelError: \d+ polls without time passing.*State\(name='Receive2'\)"),
        ("Wait0", looks_at_the_clock_for_ever, r"a loop must sleep; robot last sent State\(name='Wait0'\)"),
        ("Wait0", sleeps_no_time, r"node robot at \d+\.\d{3} s: more than 5,000 steps of it within"),
    ],
)
def test_a_controller_that_never_sleeps(
    state: str, body: machine.StateFunction, text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    fails(state, body, text, monkeypatch)


def test_a_controller_that_computes_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pytest_hricdv.runtime.kernel.STUCK_AFTER_S", 0.3)
    last = r"robot last sent State\(name='Wait0'\) in node robot at"
    text = rf"no time has passed for 0\.3 s of work, at \S+test_bad_controllers\.py:\d+; {last}"
    fails("Wait0", computes_for_ever, text, monkeypatch)


def test_a_pose_out_of_reach_ends_the_turn_and_not_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    beyond = ((3.0, *[0.0] * 8),)
    with pytest.raises(PlanningError, match=r"hip_rotor at 3\.0 rad is outside"):
        find_path((0.0,) * 9, beyond)
    monkeypatch.setattr("controller.fetching.TO_PICKUP", beyond)
    result = bench.run(LEG)
    assert result.outcome.outcomes == ("discarded",)
    assert result.outcome.ended == "nobody asks any more"
    assert not bench.times(result, "leg_ready")
