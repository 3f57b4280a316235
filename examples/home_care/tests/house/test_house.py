"""The world of a run: it moves what it is told to, in virtual time."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from carebot.messages import GripperCommand, Velocity
from house.flat import BOXES, GOALS, SEAT
from house.house import SIGNALS, UNITS, VALUES, House, HouseError

from pytest_hricdv.runtime import Kernel, NodeError, Record, Recorder


def flat(seed: int = 1, battery: float = 1.0) -> tuple[Kernel, Recorder, House]:
    kernel, recorder = Kernel(), Recorder()
    house = House(kernel, recorder, seed, battery=battery)
    kernel.world = house
    return kernel, recorder, house


def lived(does: Callable[[House, Kernel], None], limit_s: float = 100.0, seed: int = 1) -> tuple[House, Record]:
    """What is left when a node has done what it does."""
    kernel, recorder, house = flat(seed)

    def node() -> None:
        does(house, kernel)
        kernel.stop("done")

    kernel.spawn("node", node)
    assert kernel.run(limit_s) == "done"
    return house, recorder.finish()


def test_a_base_drives_as_it_is_told() -> None:
    def drive(house: House, kernel: Kernel) -> None:
        house.drive(Velocity(0.25, 0.0))
        kernel.sleep(4.0)
        house.drive(Velocity(0.0, 0.5))
        kernel.sleep(math.pi)
        house.drive(Velocity(0.0, 0.0))
        kernel.sleep(1.0)

    house, record = lived(drive)
    assert house.pose().x == pytest.approx(1.0)
    assert house.pose().heading == pytest.approx(math.pi / 2)
    assert house.contact.with_what == "nothing"
    assert max(record.signals["speed"][1]) == pytest.approx(0.25, abs=1e-4)


def test_a_wall_ends_the_way_and_is_felt() -> None:
    def drive(house: House, kernel: Kernel) -> None:
        house.drive(Velocity(0.5, 0.0))
        kernel.sleep(10.0)

    house, record = lived(drive)
    assert house.pose().x == pytest.approx(2.0 - house.base.radius_m, abs=1e-4)
    assert house.contact == ("wall", 120.0)  # what the wheels push with
    # v sqrt(m k) for 70 kg and 100 N/mm at 0.5 m/s
    assert max(record.signals["contact_force"][1]) == pytest.approx(0.5 * math.sqrt(70.0 * 1e5), abs=0.1)


def test_a_person_gets_up_walks_around_the_furniture_and_sits_down_again() -> None:
    def walk(house: House, kernel: Kernel) -> None:
        assert house.person.seated
        assert house.person.go((-3.0, 0.5), 1.0)
        assert house.wait(lambda: not house.person.walking, 20.0)
        assert house.person.at == (-3.0, 0.5)
        assert house.person.sit(1.0)
        assert house.wait(lambda: not house.person.walking, 20.0)

    house, _ = lived(walk)
    assert house.person.at == SEAT


def test_a_person_walks_around_a_robot_in_its_way() -> None:
    def walk(house: House, kernel: Kernel) -> None:
        house.person.at = (-1.5, 0.0)
        assert house.person.go((1.0, 0.0), 1.0)
        assert house.wait(lambda: not house.person.walking, 20.0)

    house, record = lived(walk)
    assert house.person.at == (1.0, 0.0)
    assert min(record.signals["distance_to_person"][1]) > 0.0
    assert house.contact.with_what == "nothing"


def test_food_is_taken_at_the_fridge_only_by_a_gripper_that_closes_there() -> None:
    def grasp(house: House, kernel: Kernel) -> None:
        house.gripper_port.command(GripperCommand(close=True))
        kernel.sleep(3.0)
        assert house.gripper_port.state().opening == 0.0
        assert not house.gripper.holds
        house.base.at = GOALS["fridge"]
        house.gripper_port.command(GripperCommand(close=False))
        kernel.sleep(3.5)
        house.gripper_port.command(GripperCommand(close=True))
        kernel.sleep(3.0)
        assert house.gripper.holds
        assert house.gripper_port.state().opening > 0.0
        house.gripper_port.command(GripperCommand(close=False))

    house, _ = lived(grasp)
    assert house.gripper.dropped  # neither at the table nor at the sink


def test_time_jumps_while_nothing_moves() -> None:
    kernel, recorder, house = flat()
    assert kernel.run(3600.0) == "limit"
    assert house.skipped_us == 3600 * 1_000_000
    assert len(recorder.finish().signals["battery"][0]) > 10  # but levels are seen when they change


def test_a_battery_is_charged_at_the_charger() -> None:
    kernel, _, house = flat(battery=0.5)
    house.base.at = GOALS["charger"]
    house.drive(Velocity(0.0, 0.1))

    def robot() -> None:
        kernel.sleep(1.0)
        house.drive(Velocity(0.0, 0.0))

    kernel.spawn("robot", robot)
    kernel.run(1800.0)
    assert house.battery_port.level() == pytest.approx(0.75, abs=0.01)


def test_runs_are_equal_to_the_bit_and_seeds_are_not() -> None:
    seen: list[tuple[float, ...]] = []

    def scans(house: House, kernel: Kernel) -> None:
        house.drive(Velocity(0.25, 0.1))
        house.dog.follow(lambda: house.base.at, 0.8, 0.7)
        for _ in range(20):
            kernel.sleep(0.1)
            seen.append(house.scan().ranges)

    hashes = [lived(scans, seed=seed)[1].sha256 for seed in (1, 1, 2)]
    assert hashes[0] == hashes[1]
    assert seen[:20] == seen[20:40] != seen[40:]


def test_a_published_jump_into_the_robot_pushes_it_away_and_is_felt() -> None:
    def jump(house: House, kernel: Kernel) -> None:
        house.base.at = (-1.0, -4.0)
        assert not house.dog_jumps(0.0, -2.0)  # into the wall
        assert not house.dog_jumps(0.0, -2.6)  # through it
        assert house.dog_jumps(-0.97, 0.01)

    house, record = lived(jump)
    assert math.dist(house.base.at, (-1.0, -4.0)) > 0.25
    assert house.dog.gap_to(house.base.at, house.base.radius_m).width_m == pytest.approx(0.0, abs=1e-9)
    assert "dog" in record.texts["contact"][1]
    assert max(record.signals["contact_force"][1]) > 1000.0


def test_what_is_no_velocity_is_refused_with_the_time() -> None:
    with pytest.raises(NodeError, match=r"forward=nan.*expected finite numbers") as raised:
        lived(lambda house, kernel: house.drive(Velocity(math.nan, 0.0)))
    assert isinstance(raised.value.__cause__, HouseError)


def test_all_signals_are_declared_and_recorded_from_the_beginning() -> None:
    _, recorder, _ = flat()
    record = recorder.finish()
    assert {*record.signals, *record.texts} == set(SIGNALS)
    assert set(UNITS) <= set(SIGNALS)
    assert set(VALUES) == {name for name, kind in SIGNALS.items() if kind is str}


def test_goals_are_free_for_the_robot() -> None:
    house = flat()[2]
    for name, at in GOALS.items():
        near_m = min(math.dist(at, box.nearest(at)) for box in BOXES)
        assert near_m > house.base.radius_m, name
