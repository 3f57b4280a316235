"""Pictures of the flat from above."""

from __future__ import annotations

from carebot.messages import Velocity
from house.flat import SOLIDS
from house.house import House
from house.picture import ROBOT_HOT_RGB, Camera, bodies

from pytest_hricdv.runtime import Kernel, Recorder


def flat() -> tuple[Kernel, House]:
    kernel = Kernel()
    house = House(kernel, Recorder(), 1)
    kernel.world = house
    return kernel, house


def test_a_picture_is_a_new_one_only_when_something_has_moved() -> None:
    kernel, house = flat()
    camera = Camera(house)
    first = camera.picture()
    kernel.run(1.0)
    assert camera.picture() is first
    house.drive(Velocity(0.25, 0.0))
    kernel.run(2.0)
    second = camera.picture()
    assert second.size == first.size
    assert second.tobytes() != first.tobytes()


def test_a_contact_is_seen() -> None:
    kernel, house = flat()
    house.drive(Velocity(1.0, 0.0))
    kernel.run(5.0)
    picture = Camera(house).picture()
    colours = {rgb for _, rgb in picture.getcolors(100_000) or []}
    assert ROBOT_HOT_RGB in colours


def test_pictures_change_nothing() -> None:
    records = []
    for pictures in (0, 5):
        kernel, recorder = Kernel(), Recorder()
        house = House(kernel, recorder, 1)
        kernel.world = house
        camera = Camera(house)
        house.dog.follow(lambda house=house: house.base.at, 0.5, 1.0)  # type: ignore[misc]
        house.drive(Velocity(0.25, 0.2))
        for second in range(1, 6):
            kernel.run(float(second))
            if pictures:
                camera.picture(fine=True)
                bodies(house)
        records.append(recorder.finish().sha256)
    assert records[0] == records[1]


def test_all_that_there_is_is_a_body() -> None:
    names = [body.name for body in bodies(flat()[1])]
    assert names == [*(solid.name for solid in SOLIDS), "robot", "person", "dog"]
