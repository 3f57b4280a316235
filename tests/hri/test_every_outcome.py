"""With disturbances every outcome comes with every pose that a person plans, each in a run of one leg."""

from __future__ import annotations

import pytest

from controller.journal import DISCARDED, NO_HUMAN_READY, OUTCOMES, SENSING_TIMEOUT
from pytest_hricdv.execution.case import RunSettings, execute
from sim.turns import SENSORS
from tests.hri import bench
from tests.hri.disturbed import Line, concrete

READY: Line = ("says_ready", {"after_s": 6.0})
SILENT: Line = ("sensors_silent", {"for_s": 150.0})
FEW = ("000", "none")
MORE = tuple(f"{pose:03b}" for pose in range(1, 8))


def turn(pose: str, extra: Line | None = None) -> list[Line]:
    """The commands of a person with this pose, or who walks off; `extra` comes once the leg is held out."""
    asks, hears, *poses = bench.leg(pose) if pose != "none" else ["tell leg", "receivesignal", "bored"]
    return [asks, hears, *([] if extra is None else [extra]), *poses]


def disturbed(pose: str, outcome: str) -> list[Line]:
    """A script with this pose, which ends so."""
    away = pose == "none"
    if outcome == NO_HUMAN_READY:
        return turn(pose, None if away else ("falls_silent", {}))
    if outcome == SENSING_TIMEOUT:
        return [SILENT, *turn(pose, READY if away else None)]
    if outcome == DISCARDED:
        return [("leg_late", {"for_s": 100.0}), *turn(pose)]
    wrong = [sensor for sensor, ready in zip(SENSORS, "000" if away else pose, strict=True) if ready == "0"]
    flips: list[Line] = [(f"{sensor}_flips", {}) for sensor in wrong]
    return [*flips, *turn(pose, READY if away else None)]


@pytest.mark.parametrize("pose", [*FEW, *(pytest.param(pose, marks=pytest.mark.slow) for pose in MORE)])
def test_a_leg_ends_in_each_way_whatever_the_person_plans(pose: str) -> None:
    for outcome in OUTCOMES:
        test = concrete(disturbed(pose, outcome), sensing_timeout_s=20.0)
        result = execute(RunSettings(bench.testbench()), test)
        boredom = "bored" if pose == "none" else "not_bored"
        assert list(result.outcome.cross["handover"]) == [("1", boredom, pose, outcome)]
