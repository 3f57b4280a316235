"""A fault of each kind, planted into the controller, is caught by its requirement; without it, the same tests pass."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import islice

import pytest

from controller import fetching, machine
from controller.robot import Robot
from controller.settings import Settings
from pytest_hricdv.execution.case import CaseResult
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.monitor import Verdict
from sim.layout import PICKUP_M
from sim.world import World
from tests.hri import bench
from tests.sampling import mostly_slow

PLANNED_TOO_FAST_RAD_S = 0.30
DEADLINE_S = 10.0
PATIENCE_S = 5.0


def verdicts(result: CaseResult) -> str:
    """The verdicts of R1 to R4."""
    return " ".join(verdict.verdict for verdict in result.verdicts[:4])


def failed(result: CaseResult, requirement: str) -> Verdict:
    """The verdict of a requirement that failed."""
    verdict = result.verdict(requirement)
    assert verdict.verdict == "Failed"
    assert verdict.triggers == verdict.passes + verdict.failures + verdict.pending
    return verdict


@pytest.mark.parametrize("pose", ["111", "101", "110"])
def test_the_controller_as_it_is_passes_what_its_variants_fail(pose: str) -> None:
    result = bench.run(bench.concrete(bench.leg(pose)))
    assert verdicts(result) == ("Passed NC Passed Passed" if pose == "111" else "NC Passed Passed Passed")
    assert result.verdict("R3").triggers == 1
    assert result.verdict("R4").margin == pytest.approx(0.0, abs=0.01)


def test_a_release_without_pressure_fails_r2(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(machine.STATES, "Decide", lambda robot: "ready")
    result = bench.run(bench.concrete(bench.leg("101")))
    verdict = failed(result, "R2")
    (violation,) = verdict.violations
    assert (verdict.triggers, verdict.failures) == (1, 1)
    assert violation.values["reading.gaze"]
    assert violation.values["reading.location"]
    assert not violation.values["reading.pressure"]
    assert bench.number(violation, "leg_offset") < 0.15
    assert [violation.trigger_s] == bench.times(result, "reading")
    assert 0.0 < violation.time_s - violation.trigger_s < 1.0  # as long as fingers take to open
    assert verdicts(result) == "NC Failed Passed Passed"


def test_a_robot_that_never_releases_fails_r1_at_the_deadline(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(machine.STATES, "Release", lambda robot: "stuck")
    monkeypatch.setitem(machine.TRANSITIONS, ("Release", "stuck"), "Discard")
    result = bench.run(bench.concrete(bench.leg()))
    verdict = failed(result, "R1")
    (violation,) = verdict.violations
    assert (verdict.triggers, verdict.failures) == (1, 1)
    assert violation.margin is not None
    assert violation.margin < 0.0  # the run went on without it
    assert [violation.trigger_s] == bench.times(result, "reading", gaze=True, pressure=True, location=True)
    assert violation.time_s == pytest.approx(violation.trigger_s + DEADLINE_S)
    assert result.outcome.outcomes == ("discarded",)
    assert verdicts(result) == "Failed NC Passed Passed"


def test_planning_at_0_30_rad_s_fails_r4_with_the_speed_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("controller.settings.Settings", partial(Settings, max_speed_rad_s=PLANNED_TOO_FAST_RAD_S))
    result = bench.run(bench.concrete(bench.leg()))
    verdict = failed(result, "R4")
    for violation in verdict.violations:
        assert 0.25 <= bench.number(violation, "arm_speed") <= PLANNED_TOO_FAST_RAD_S
        assert violation.margin is not None
        assert 0.25 - PLANNED_TOO_FAST_RAD_S <= violation.margin <= 0.0
    assert verdict.margin == pytest.approx(0.25 - PLANNED_TOO_FAST_RAD_S, abs=0.015)
    assert verdict.triggers == motions(result)
    assert verdicts(result) == "Passed NC Passed Failed"


@pytest.mark.slow
@pytest.mark.parametrize(("on_time_s", "verdict"), [(300.0, "Passed"), (100.0, "Failed")])
def test_a_good_table_that_is_called_late_too_early_fails_r5(
    on_time_s: float, verdict: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("controller.settings.Settings", partial(Settings, on_time_s=on_time_s))
    result = bench.run(bench.concrete(bench.leg() * 4, seed=4))
    r5 = result.verdict("R5")
    assert result.outcome.outcomes == ("released",) * 4
    assert (r5.verdict, r5.triggers) == (verdict, 1)
    if verdict == "Failed":
        (violation,) = r5.violations
        assert violation.values["table_done.on_time"] is False
        assert 100.0 < bench.number(violation, "table_done.duration_s") < 300.0


def motions(result: CaseResult) -> int:
    """Times at which the arm began to move: its speed rises above 0.005 rad/s after it stood."""
    stands, begun = True, 0
    for speed in result.record.signals["arm_speed"][1]:
        if stands and speed > 0.005:
            stands, begun = False, begun + 1
        elif speed <= 0.001:
            stands = True
    return begun


@pytest.mark.parametrize(("grip_s", "verdict"), [(6.0, "Passed"), (12.0, "Failed"), (14.0, "Failed")])
def test_a_person_who_grips_hand_and_leg_for_long_makes_a_release_miss_its_deadline(
    grip_s: float, verdict: str
) -> None:
    result = bench.run(bench.concrete(bench.leg(), grip_s=grip_s))
    r1 = result.verdict("R1")
    assert (r1.verdict, r1.triggers) == (verdict, 1)
    (sensed_s,) = bench.times(result, "reading")
    falls = [at for at, held in zip(*result.record.signals["leg_held"], strict=True) if not held and at > sensed_s]
    assert falls[0] - sensed_s == pytest.approx(grip_s, abs=0.5)
    assert result.outcome.outcomes == ("released",)
    if verdict == "Failed":
        (violation,) = r1.violations
        assert violation.time_s == pytest.approx(sensed_s + DEADLINE_S)
        assert violation.values["leg_held"] is True
    else:
        assert r1.margin == pytest.approx(DEADLINE_S - grip_s, abs=0.5)


def strays(test: ConcreteTest) -> float:
    """How near (m) the person's resting hand comes to a leg that waits to be fetched, while the robot fetches it."""
    rests = [action.parameters for action in test.actions if action.command == "tell leg"]
    return min(math.dist((rest["rest_x_m"], rest["rest_y_m"], rest["rest_z_m"]), PICKUP_M) for rest in rests)


def in_by_hand() -> Iterator[ConcreteTest]:
    """Tests of a person who stays to the end, first those whose hand strays nearest to the pickup place."""
    stays = [test for test in bench.suite("by-hand") if test.actions and test.actions[2].command != "bored"]
    return iter(sorted(stays, key=strays))


def in_pseudorandom() -> Iterator[ConcreteTest]:
    """Tests of a person whose hand moves at any time."""
    return bench.suite("pseudorandom")


def failing_r3(tests: Iterable[ConcreteTest], number: int) -> list[CaseResult]:
    """The first runs that fail R3."""
    results = (bench.run(test) for test in tests)
    return list(islice((result for result in results if result.verdict("R3").verdict == "Failed"), number))


@pytest.mark.parametrize(("tests", "number"), mostly_slow([(in_by_hand, 1), (in_pseudorandom, 1), (in_by_hand, 4)], 1))
def test_with_crush_prevention_r3_does_not_fail_where_it_fails_without(
    tests: Callable[[], Iterator[ConcreteTest]], number: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    without = failing_r3(tests(), number)
    assert len(without) == number
    for result in without:
        assert_the_hand_was_too_close(result)
        assert "Failed" not in {result.verdict(name).verdict for name in ("R1", "R2", "R4")}
    prevent_crushing(monkeypatch)
    for result in without:
        careful = bench.run(result.test)
        assert careful.verdict("R3").verdict in ("Passed", "NC")
        assert careful.verdict("R3").triggers <= result.verdict("R3").triggers


def assert_the_hand_was_too_close(result: CaseResult) -> None:
    """R3 failed, each time while the robot's hand closed and the person's was nearer than 0.05 m."""
    verdict = failed(result, "R3")
    closing = result.record.signals["hand_closing"]
    starts = [at for at, closes in zip(*closing, strict=True) if closes]
    assert verdict.triggers == len(starts)
    for violation in verdict.violations:
        assert violation.trigger_s in starts
        assert 0.0 <= violation.time_s - violation.trigger_s < 1.5
        assert violation.values["hand_closing"] is True
        assert -0.1 < bench.number(violation, "hand_distance") < 0.05
        assert violation.margin is not None
        assert -0.15 < violation.margin < 0.0


def prevent_crushing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The robot looks where the person's hand is, waits until it is away, and closes only then."""
    worlds: list[World] = []

    class Seen(World):
        def _build(self) -> None:
            super()._build()
            worlds.append(self)

    close = fetching.grasp

    def careful(robot: Robot) -> bool:
        until_s = robot.clock.now_s() + PATIENCE_S
        while worlds[-1].gripper.human_distance() < 0.3:
            if robot.clock.now_s() > until_s:
                return False
            robot.clock.sleep(0.1)
        return close(robot)

    monkeypatch.setattr("sim.workshop.World", Seen)
    monkeypatch.setattr(fetching, "grasp", careful)
