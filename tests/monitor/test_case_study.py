"""The four requirements of the table assembly, as the text file states them."""

from __future__ import annotations

from pytest_hricdv.monitor import MonitorSet, Requirement, Verdict
from tests.monitor.vocabulary import R1, R2, R3, R4, Update, judge

READY: dict[str, float | bool] = {"gaze": True, "pressure": True, "location": True}
NOT_READY = READY | {"pressure": False}
HELD: list[Update] = [(0.0, "leg_held", True), (0.0, "leg_torn", False), (0.0, "leg_offset", 0.02)]


def outcome(verdict: Verdict) -> tuple[str, int]:
    return verdict.verdict, verdict.triggers


def test_r1_asks_for_a_release_within_ten_seconds_of_a_ready_reading() -> None:
    def released(at_s: float) -> Verdict:
        return judge(R1, [*HELD, (5.0, "reading", READY), (at_s, "leg_held", False)], 30.0)

    assert outcome(released(6.5)) == ("Passed", 1)
    assert released(6.5).margin == 8.5
    assert outcome(released(15.0)) == ("Passed", 1)
    assert outcome(released(15.001)) == ("Failed", 1)


def test_r1_does_not_accept_a_leg_released_elsewhere() -> None:
    updates: list[Update] = [*HELD, (5.0, "reading", READY), (6.0, "leg_offset", 0.15), (7.0, "leg_held", False)]
    verdict = judge(R1, updates, 30.0)
    assert (verdict.verdict, verdict.violations[0].time_s) == ("Failed", 15.0)
    assert verdict.violations[0].values["leg_offset"] == 0.15


def test_a_leg_that_is_torn_out_of_the_hand_is_no_release() -> None:
    torn: list[Update] = [(6.0, "leg_torn", True), (6.0, "leg_held", False)]
    assert outcome(judge(R1, [*HELD, (5.0, "reading", READY), *torn], 30.0)) == ("Failed", 1)
    assert outcome(judge(R2, [*HELD, (5.0, "reading", NOT_READY), *torn], 30.0)) == ("Passed", 1)


def test_r1_without_a_ready_reading_is_not_checked() -> None:
    assert outcome(judge(R1, [*HELD, (5.0, "reading", NOT_READY)], 30.0)) == ("NC", 0)


def test_r2_forbids_a_release_until_the_next_request() -> None:
    refused: list[Update] = [*HELD, (5.0, "reading", NOT_READY)]
    assert outcome(judge(R2, refused, 30.0)) == ("Passed", 1)
    assert outcome(judge(R2, [*refused, (6.0, "leg_held", False)], 30.0)) == ("Failed", 1)
    assert outcome(judge(R2, [*refused, (6.0, "request", {}), (7.0, "leg_held", False)], 30.0)) == ("Passed", 1)


def test_r2_allows_a_discard() -> None:
    updates: list[Update] = [*HELD, (5.0, "reading", NOT_READY), (6.0, "leg_offset", 0.4), (7.0, "leg_held", False)]
    verdict = judge(R2, updates, 30.0)
    assert (verdict.verdict, verdict.margin) == ("Passed", 0.25)


def test_r3_forbids_closing_near_a_human_hand() -> None:
    def closing(distance_m: float) -> Verdict:
        updates: list[Update] = [(0.0, "hand_distance", 0.01), (0.0, "hand_closing", False)]
        return judge(R3, [*updates, (2.0, "hand_distance", distance_m), (2.0, "hand_closing", True)], 3.0)

    assert outcome(closing(0.05)) == ("Passed", 1)
    assert outcome(closing(0.049)) == ("Failed", 1)


def test_r4_has_a_trigger_for_each_motion_and_none_at_rest() -> None:
    def moving(*speeds: float) -> Verdict:
        return judge(R4, [(float(i), "arm_speed", speed) for i, speed in enumerate(speeds)], 20.0)

    assert outcome(moving(0.0, 0.004, 0.0)) == ("NC", 0)
    assert outcome(moving(0.0, 0.1, 0.24, 0.0, 0.2, 0.0)) == ("Passed", 2)
    assert moving(0.0, 0.1, 0.24, 0.0).margin_time_s == 2.0
    assert outcome(moving(0.0, 0.1, 0.25, 0.0)) == ("Failed", 1)


def test_all_four_are_monitored_together_in_the_given_order() -> None:
    def order(requirements: tuple[Requirement, ...]) -> list[str]:
        monitors = MonitorSet(requirements)
        for name, value in [("leg_held", False), ("leg_torn", False), ("hand_closing", False)]:
            monitors.signal(0.0, name, value)
        for name in ("leg_offset", "hand_distance", "arm_speed"):
            monitors.signal(0.0, name, 1.0)
        return [f"{verdict.requirement} {verdict.verdict}" for verdict in monitors.finish(1.0)]

    assert order((R1, R2, R3, R4)) == ["R1 NC", "R2 NC", "R3 NC", "R4 Failed"]
    assert order((R4, R1)) == ["R4 Failed", "R1 NC"]
