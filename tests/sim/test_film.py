"""A film of the table: of a run in which the robot closes its hand next to a person's."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from pytest_hricdv.execution.case import CaseResult, RunSettings
from pytest_hricdv.extra.film import schedule
from pytest_hricdv.extra.film.film_maker import FilmMaker
from pytest_hricdv.extra.film.recorder import ALARM
from pytest_hricdv.extra.film.records import FOLDER, FilmResult
from pytest_hricdv.extra.film.video import FRAMES_PER_S
from pytest_hricdv.runtime import Recorder
from sim.film import GAP_PX, HAND_PX, HEIGHT_PX, SCENE_PX, Camera, visible
from sim.world import World
from tests.extra.film.decoded import decoded
from tests.hri import bench

IN_THE_WAY = {"rest_x_m": 0.49, "rest_y_m": -0.27, "rest_z_m": 0.53}
SHOWN = ("request", "violation", "grasp", "offer", "decision", "end")


@dataclass(frozen=True)
class Filmed:
    """A filmed run: its result, the report's entry, and the folder of the report."""

    result: CaseResult
    film: FilmResult
    folder: Path

    def panels(self) -> dict[str, NDArray[np.int16]]:
        """The key frames of the strip, without their titles."""
        assert self.film.strip is not None
        with Image.open(self.folder / self.film.strip) as strip:
            pixels = np.asarray(strip.convert("RGB"), dtype=np.int16)
        height, width = pixels.shape[0] // 2, pixels.shape[1] // 3
        parts = (
            pixels[row : row + height, left : left + width] for row in (0, height) for left in (0, width, 2 * width)
        )
        return dict(zip(SHOWN, parts, strict=True))


@pytest.fixture(scope="module")
def filmed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Filmed]:
    """A film with fewer pictures than usual: one in two seconds, and all in a second around the violation."""
    folder = tmp_path_factory.mktemp("report")
    result = bench.run(bench.concrete(bench.leg("111"), seed=3, **IN_THE_WAY))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(schedule, "SHORTEST_STEP_S", 2.0)
        patch.setattr(schedule, "SLOW_AFTER_S", 0.5)
        yield Filmed(
            result, FilmMaker(RunSettings(bench.testbench(), bench.requirements()), folder).film(result), folder
        )


def skin(pixels: NDArray[np.int16]) -> int:
    """How many pixels have the colour of skin: clearly more red than green, and more green than blue."""
    red, green, blue = (pixels[..., channel] for channel in range(3))
    return int(np.count_nonzero((red - green > 20) & (green - blue > 10) & (red > 120) & (blue > 70)))


def fingers(pixels: NDArray[np.int16]) -> int:
    """How many pixels have the colour of the robot's fingers."""
    red, green, blue = (pixels[..., channel] for channel in range(3))
    return int(np.count_nonzero((blue - green > 40) & (green - red > 30)))


@pytest.mark.slow
def test_the_run_that_is_filmed_violates_r3_and_filming_changes_nothing_in_it(filmed: Filmed) -> None:
    assert filmed.result.verdict("R3").verdict == "Failed"
    assert filmed.film.note == ""  # it would say that the record differs
    assert filmed.film.video is not None
    assert filmed.film.video.startswith(f"{FOLDER}/{filmed.result.test.id}.")
    assert sorted(path.name for path in (filmed.folder / FOLDER).iterdir()) == sorted(
        Path(getattr(filmed.film, kind)).name for kind in ("video", "strip")
    )


def test_the_film_can_be_read_and_is_as_long_as_said(filmed: Filmed) -> None:
    assert filmed.film.video is not None
    frames = decoded(filmed.folder / filmed.film.video, (SCENE_PX + GAP_PX + HAND_PX, 512))
    assert len(frames) == filmed.film.frames > 30
    assert len(frames) / FRAMES_PER_S == pytest.approx(filmed.film.seconds, abs=0.01)
    assert len({frame.tobytes() for frame in frames}) > 20


def test_the_strip_has_six_key_frames_that_differ(filmed: Filmed) -> None:
    panels = filmed.panels()
    for name, panel in panels.items():
        assert panel.shape[1] == 640
        for other, compared in panels.items():
            changed = np.abs(panel - compared).max(axis=-1) > 25
            assert name == other or np.count_nonzero(changed) > 1000, (name, other)


def test_the_persons_hand_is_seen_next_to_the_robots_fingers_when_it_is_too_close(filmed: Filmed) -> None:
    panels = filmed.panels()
    near = round(640 * (SCENE_PX + GAP_PX) / (SCENE_PX + GAP_PX + HAND_PX))
    violation, request = (panels[name][40:300, near + 6 : -6] for name in ("violation", "request"))
    assert skin(violation) > 2000
    assert fingers(violation) > 1000
    assert skin(violation) > 3 * skin(request)
    assert tuple(panels["violation"][2, 2]) == ALARM
    assert tuple(panels["request"][2, 2]) != ALARM


def test_a_camera_reads_the_world_only_and_says_when_nothing_moved() -> None:
    with World(Recorder()) as world:
        before = visible(world)
        camera = Camera(world)
        first = camera.picture()
        assert first.size == (SCENE_PX + GAP_PX + HAND_PX, HEIGHT_PX)
        assert camera.picture() is first
        fine = camera.picture(fine=True)
        assert fine.size == first.size
        assert fine.tobytes() != first.tobytes()  # shadows
        assert camera.picture() is first
        world.person.hand.move((0.6, 0.0, 0.6))
        world.advance(1_000_000)
        assert camera.picture() is not first
        camera.close()
        assert visible(world).keys() == before.keys()
