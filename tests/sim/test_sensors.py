"""What the sensors say is what the bodies do, but for seeded errors; and they speak only when heard."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from sim.engine import SimulationError
from sim.gaze import Gaze, head_pose
from sim.sensors import Sensors, Truth, classify

from .stage import Stage

READY = Gaze(0.15, 0.55, 30.0)
GAZES = {
    "ready": (READY, True),
    "at the very limits": (Gaze(0.2, 0.6, 39.999), True),
    "too far aside": (Gaze(0.21, 0.55, 30.0), False),
    "too far away": (Gaze(0.15, 0.61, 30.0), False),
    "looking elsewhere": (Gaze(0.15, 0.55, 40.001), False),
    "just not at the limit": (Gaze(0.15, 0.55, 40.0001), False),
}
HANDS = {
    "on the leg": ((0.02, 0.01, -0.03), True),
    "at the limits": ((0.3, -0.3, 0.3), True),
    "too far in x": ((0.31, 0.0, 0.0), False),
    "too far in y": ((0.0, -0.31, 0.0), False),
    "too far in z": ((0.0, 0.0, 0.31), False),
    "away": ((0.6, 0.6, 0.6), False),
}


@pytest.fixture
def stage() -> Iterator[Stage]:
    with Stage() as stage:
        yield stage


def make_ready(stage: Stage, pull_n: float = 8.0) -> None:
    leg = stage.world.legs.current
    x, y, z = leg.pose()[0]
    head, hand = stage.world.person.head, stage.world.person.hand
    took_s = max(head.move(*head_pose(READY, 1.0, (x, y, z))), hand.move((x + 0.03, y, z - 0.03)))
    stage.world.person.pull(pull_n)
    stage.kernel.sleep(took_s + 1.0)


@pytest.mark.parametrize(("gaze", "ready"), GAZES.values(), ids=GAZES)
def test_gaze_is_read_from_the_head(stage: Stage, gaze: Gaze, ready: bool) -> None:
    leg = stage.world.legs.current
    place, turn = head_pose(gaze, -1.0, leg.pose()[0])

    def look() -> None:
        stage.kernel.sleep(stage.world.person.head.move(place, turn))
        assert classify(stage.world) == Truth(gaze=ready, pressure=False, location=False)

    assert stage.run(look) == "over"


@pytest.mark.parametrize(("offset", "ready"), HANDS.values(), ids=HANDS)
def test_location_is_read_from_the_hand(stage: Stage, offset: tuple[float, float, float], ready: bool) -> None:
    leg = stage.world.legs.current
    x, y, z = leg.pose()[0]

    def reach() -> None:
        stage.kernel.sleep(stage.world.person.hand.move((x + offset[0], y + offset[1], z + offset[2])))
        assert classify(stage.world).location == ready

    assert stage.run(reach) == "over"


@pytest.mark.parametrize(("pull_n", "ready"), [(0.0, False), (2.0, False), (6.0, True), (10.0, True)])
def test_pressure_is_read_from_the_palm(stage: Stage, pull_n: float, ready: bool) -> None:
    def hold() -> None:
        assert stage.fetch()
        make_ready(stage, pull_n)
        assert classify(stage.world) == Truth(gaze=True, pressure=ready, location=True)

    assert stage.run(hold) == "over"


def test_errors_come_at_their_rate_and_only_in_their_direction(stage: Stage) -> None:
    def read_many() -> None:
        idle = Sensors(stage.world, stage.bus.port("s"), stage.kernel, seed=1, error_probability=0.05)
        assert stage.fetch()
        alone = [idle.read() for _ in range(4000)]
        assert not any(reading.gaze or reading.location for reading in alone)
        assert 0.04 < sum(reading.pressure for reading in alone) / 4000 < 0.06
        make_ready(stage)
        ready = [idle.read() for _ in range(4000)]
        assert all(reading.pressure for reading in ready)
        assert 0.04 < sum(not reading.gaze for reading in ready) / 4000 < 0.06
        assert 0.04 < sum(not reading.location for reading in ready) / 4000 < 0.06

    assert stage.run(read_many) == "over"


@pytest.mark.parametrize(("probability", "outage"), [(-0.1, 0), (1.1, 0), (float("nan"), 0), (0.05, -1)])
def test_invalid_settings_are_refused(stage: Stage, probability: float, outage: int) -> None:
    with pytest.raises(SimulationError):
        Sensors(stage.world, stage.bus.port("s"), stage.kernel, 0, probability, outage)
