"""A person's hand that is in the way when the robot closes its own: distance and force show in R3's violation."""

from __future__ import annotations

from pytest_hricdv.monitor.verdict import Violation
from tests.hri import bench


def violation_with_the_hand_at(x_m: float, y_m: float, z_m: float) -> Violation:
    test = bench.concrete(bench.leg("111"), seed=3, rest_x_m=x_m, rest_y_m=y_m, rest_z_m=z_m)
    verdict = bench.run(test).verdict("R3")
    assert verdict.verdict == "Failed"
    return verdict.violations[0]


def test_fingers_that_close_on_a_hand_violate_r3_by_distance_and_by_force() -> None:
    violation = violation_with_the_hand_at(0.40, -0.28, 0.62)
    assert bench.number(violation, "hand_distance") < 0.05
    assert violation.margin is not None
    assert violation.margin < -0.05  # they touched
    assert bench.number(violation, "hand_contact_force") > 5.0  # N
