"""The agent robot_code as an oracle: the controller conforms as it is, in rare situations too, and with faults not."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import pytest

from controller import deciding, finishing, machine
from controller.ports import LegReady, TurnDone
from controller.robot import Robot
from controller.settings import Settings
from pytest_hricdv.execution.case import RunSettings, execute, feature_criteria
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.monitor import Criterion, Verdict
from tests.hri import bench

LEG = bench.leg()
NOT_READY = bench.leg("011")
SILENT = ["tell leg", "receivesignal"]


@cache
def oracle() -> tuple[Criterion, ...]:
    return feature_criteria(bench.testbench())


def judged(test: ConcreteTest) -> Verdict:
    """The verdict MODEL of a run."""
    return execute(RunSettings(bench.testbench(), oracle()), test).verdict("MODEL")


@pytest.mark.parametrize(
    "test",
    [
        bench.concrete(LEG + NOT_READY),
        bench.concrete(LEG, outage_turn=1, sensing_timeout_s=37.2914),
        bench.concrete(LEG, grip_s=14.0),
        bench.concrete(LEG, rest_x_m=0.43, rest_y_m=-0.25, rest_z_m=0.60),
        bench.concrete(["tell leg", "tell humanReady", *LEG[1:]]),
        bench.concrete([*NOT_READY, "tell leg", "tell leg"]),
        bench.concrete(["tell leg", "receivesignal", "tell humanReady"], voice_s=14.75),
        bench.concrete(["tell leg", "receivesignal", "tell humanReady"], voice_s=14.9),
    ],
    ids=[
        "released and discarded",
        "sensors are silent",
        "the person grips the hand",
        "a hand is in the way",
        "ready is said too early",
        "requests while it is at work",
        "ready at the last moment",
        "ready after the last moment",
    ],
)
def test_the_controller_as_it_is_conforms(test: ConcreteTest) -> None:
    verdict = judged(test)
    assert (verdict.verdict, verdict.failures, verdict.pending) == ("Passed", 0, 0), verdict.violations
    assert verdict.passes > 7


def _twice(robot: Robot) -> None:
    turn = robot.journal.add(robot.outcome, robot.reason, robot.turn_began_s, robot.clock.now_s())
    for _ in range(2):
        robot.bus.publish(TurnDone(turn.number, turn.outcome))


def _silent(robot: Robot) -> str:
    robot.clock.sleep(1000.0)
    return "table done"


def _wrong_turn(robot: Robot) -> str:
    robot.readies.clear()
    robot.bus.publish(LegReady(robot.turn + 1))
    return "told"


def _hands_over(robot: Robot) -> str:
    robot.hand.open()
    return deciding.wait0(robot)


def _method(name: str, function: Callable[[Robot], None]) -> Callable[[pytest.MonkeyPatch], None]:
    return lambda patch: patch.setattr(Robot, name, function)


def _state(name: str, function: Callable[[Robot], str]) -> Callable[[pytest.MonkeyPatch], None]:
    return lambda patch: patch.setitem(machine.STATES, name, function)


def _next(state: str, outcome: str, follows: str) -> Callable[[pytest.MonkeyPatch], None]:
    return lambda patch: patch.setitem(machine.TRANSITIONS, (state, outcome), follows)


def _setting(name: str, value: float) -> Callable[[pytest.MonkeyPatch], None]:
    def plant(patch: pytest.MonkeyPatch) -> None:
        made = Settings.__init__

        def init(self: Settings, **given: float) -> None:
            made(self, **{**given, name: value})  # type: ignore[arg-type]

        patch.setattr(Settings, "__init__", init)

    return plant


@pytest.mark.parametrize(
    ("plant", "lines", "told"),
    [
        (_state("Send1", lambda robot: "told"), LEG, "expected offer(1) 3 to 10 s after"),
        (_state("Send1", _wrong_turn), LEG, "expected offer(1) 3 to 10 s after * observed leg_ready(turn=2)"),
        (_method("end_turn", _twice), LEG, "expected nothing, * observed turn_done("),
        (
            lambda patch: patch.setattr(Robot, "end_turn", lambda robot: None),
            LEG,
            "expected report_turn(1,released) 3 to 15",
        ),
        (
            _method("begin_turn", lambda robot: None),
            SILENT + NOT_READY,
            "expected report_turn(2,discarded) 3 to 15",
        ),
        (_setting("ready_poll_s", 25.0), SILENT, "expected @p6 within 0.1 s of"),
        (_setting("ready_poll_s", 0.2), SILENT, 'expected nothing, * observed state(name="Timeout2")'),
        (_setting("turns", 1), LEG, "expected nothing, * observed table_done("),
        (_setting("settle_s", 0.5), LEG, 'expected reading_wanted 1.9 to 2.1 s after * observed state(name="Sensing")'),
        (_state("Wait0", _hands_over), LEG, "expected reading_wanted * observed leg_held = False"),
        (_state("Decide", lambda robot: "ready"), NOT_READY, 'expected @p12 within * observed state(name="Release")'),
        (_next("Decide", "ready", "Discard"), LEG, 'expected @p10 within * observed state(name="Discard")'),
        (_next("Timeout2", "give up", "Wait0"), SILENT, 'expected @p12 within * observed state(name="Wait0")'),
        (_state("Release", _silent), LEG, "expected release within 20 s of"),
        (_state("Timeout2", lambda robot: "give up"), SILENT, 'expected report_turn(1,"no-human-ready")'),
        (lambda patch: patch.setattr(finishing, "TO_RESUPPLY", ()), NOT_READY, "expected drop 3 to 8 s after"),
    ],
    ids=[
        "no announcement",
        "a wrong number",
        "a turn reported twice",
        "a turn never reported",
        "state kept over turns",
        "too patient",
        "too impatient",
        "counts too few turns",
        "does not let the person settle",
        "opens too early",
        "decides without looking",
        "discards what it should release",
        "does not discard",
        "falls silent",
        "a wrong reason",
        "drops the leg beside the bin",
    ],
)
def test_a_fault_of_the_controller_deviates(
    monkeypatch: pytest.MonkeyPatch, plant: Callable[[pytest.MonkeyPatch], None], lines: list[str], told: str
) -> None:
    plant(monkeypatch)
    [violation] = judged(bench.concrete(lines)).violations
    begin, _, end = told.partition("*")
    assert violation.text.startswith(begin), violation.text
    assert end.strip() in violation.text, violation.text
