"""The base in MuJoCo: what it shares with the planar one, and by how much they differ."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

pytest.importorskip("mujoco")

from carebot.messages import Velocity
from house.base import BODIES, PUSHES_N, impact_n
from house.dynamic import Dynamic
from house.flat import BOXES
from house.house import House
from house.shapes import gap_to_box

from pytest_hricdv.runtime import Kernel, Record, Recorder

GIVES_M = 0.05
"""Contacts give way: by v / omega, which is 3 cm for a person at 0.6 m/s."""


def lived(
    does: Callable[[House, Kernel], None], *, dynamic: bool = True, limit_s: float = 100.0
) -> tuple[House, Record]:
    kernel, recorder = Kernel(), Recorder()
    house = House(kernel, recorder, 1, Dynamic() if dynamic else None)
    kernel.world = house

    def node() -> None:
        does(house, kernel)
        kernel.stop("done")

    kernel.spawn("node", node)
    assert kernel.run(100.0) == "done"
    return house, recorder.finish()


def tour(house: House, kernel: Kernel) -> None:
    for forward, turn, duration_s in ((0.25, 0.0, 4.0), (0.0, 0.5, math.pi), (0.25, 0.3, 5.0), (-0.2, 0.0, 1.0)):
        house.drive(Velocity(forward, turn))
        kernel.sleep(duration_s)
        house.drive(Velocity(0.0, 0.0))
        kernel.sleep(1.0)


def test_both_bases_end_a_tour_at_the_same_place() -> None:
    (one, _), (other, record) = lived(tour), lived(tour, dynamic=False)
    assert math.dist(one.base.at, other.base.at) < 0.02
    assert one.base.heading_rad == pytest.approx(other.base.heading_rad, abs=0.02)
    assert max(record.signals["speed"][1]) == pytest.approx(0.25, abs=1e-3)


def test_a_base_that_stands_lets_time_jump() -> None:
    def stand(house: House, kernel: Kernel) -> None:
        house.drive(Velocity(0.25, 0.5))
        kernel.sleep(2.0)
        house.drive(Velocity(0.0, 0.0))
        kernel.sleep(50.0)

    house, _ = lived(stand)
    assert house.still
    assert house.skipped_us > 48 * 1_000_000


@pytest.mark.parametrize("speed_m_s", [0.1, 0.25, 0.5])
@pytest.mark.parametrize("what", ["wall", "person", "dog"])
def test_the_peak_of_an_impact_is_that_of_the_formula_and_the_motors(what: str, speed_m_s: float) -> None:
    def run_into(house: House, kernel: Kernel) -> None:
        if what == "person":
            house.person.at = (1.3, 0.0)
        elif what == "dog":
            house.dog.at = (1.3, 0.0)
        house.drive(Velocity(speed_m_s, 0.0))
        kernel.sleep(2.0 / speed_m_s + 2.0)

    house, record = lived(run_into)
    impact = impact_n(speed_m_s, BODIES[what])
    peak = max(record.signals["contact_force"][1])
    assert 0.9 * impact < peak < PUSHES_N + math.hypot(PUSHES_N, impact)  # the motors push all the while
    assert house.contact.with_what == what
    assert house.contact.force_n == pytest.approx(PUSHES_N, rel=0.1)  # what is left of it


def test_nothing_is_passed_through() -> None:
    worst: list[float] = []

    def bump(house: House, kernel: Kernel) -> None:
        house.dog.follow(lambda: house.base.at, 0.3, 1.0)
        for turn in range(8):
            house.drive(Velocity(0.6, 0.7 * (-1) ** turn))
            for _ in range(40):
                kernel.sleep(0.1)
                at = house.base.at
                worst.append(min(gap_to_box(at, house.base.radius_m, box).width_m for box in BOXES))
                worst.append(house.dog.gap_to(at, house.base.radius_m).width_m)

    _, record = lived(bump)
    assert -GIVES_M < min(worst) < 0.0
    assert "wall" in record.texts["contact"][1]


def test_runs_are_equal_to_the_bit() -> None:
    def mixed(house: House, kernel: Kernel) -> None:
        house.person.go((-1.0, 1.5), 1.0)
        tour(house, kernel)
        house.drive(Velocity(0.5, 0.1))
        kernel.sleep(9.0)

    assert lived(mixed)[1].sha256 == lived(mixed)[1].sha256


def test_a_wake_between_steps_of_physics_changes_little() -> None:
    def often(house: House, kernel: Kernel) -> None:
        house.drive(Velocity(0.25, 0.0))
        for _ in range(1000):
            kernel.sleep(0.0037)

    def seldom(house: House, kernel: Kernel) -> None:
        house.drive(Velocity(0.25, 0.0))
        kernel.sleep(3.7)

    assert lived(often)[0].base.at[0] == pytest.approx(lived(seldom)[0].base.at[0], abs=1e-3)
