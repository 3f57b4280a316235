"""`--hri-film`: the runs of failing tests are replayed, filmed, and linked from the report."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from tests.plugin.project import change, report
from tests.report.parsed import Page, details

for _name in ("PIL.Image", "PIL.ImageDraw", "PIL.ImageFont", "PIL.PngImagePlugin", "PIL.GifImagePlugin"):
    importlib.import_module(_name)  # once, like what conftest loads

BRIGHT = "rl-hall-polite-6c5fa14f"
CAMERA = '''
class Hall:
    """A world in which nothing goes on by itself."""

    def __init__(self, lamp):
        self.lamp = lamp

    def advance(self, target_us):
        return target_us

    def observe(self):
        pass


class LampCamera:
    """Shows how bright the lamp is."""

    def __init__(self, world):
        self.lamp, self.taken = world.lamp, {}

    def picture(self, *, fine=False):
        from PIL import Image

        shade = round(2.5 * self.lamp.level)
        return self.taken.setdefault(shade, Image.new("RGB", (640, 240), (shade, shade, 60)))

    def close(self):
        pass


def run(run):
'''


@pytest.fixture
def filmed(lamps: pytest.Pytester) -> pytest.Pytester:
    """The lamps with a camera."""
    change(lamps.path, "conftest.py", "\ndef run(run):\n", CAMERA)
    change(lamps.path, "conftest.py", "CrossProduct, Model", "CrossProduct, Film, Model")
    film = (
        "simulation=Simulation(film="
        'Film(LampCamera, {"wish": "wish", "answer": "answer"}, state="switched.level", period_s=0.1)),'
    )
    change(
        lamps.path,
        "conftest.py",
        '        cross={"light": CrossProduct({"place"',
        f'        {film}\n        cross={{"light": CrossProduct({{"place"',
    )
    lamp = "        def set(self, level):\n"
    change(lamps.path, "conftest.py", lamp, f"{lamp}            self.level = level\n")
    change(lamps.path, "conftest.py", "    lamp.set(0.0)\n", "    lamp.set(0.0)\n    run.kernel.world = Hall(lamp)\n")
    return lamps


def films(folder: Path) -> dict[str, dict[str, Any]]:
    """Id -> film, of the report."""
    return {test["id"]: test["film"] for test in report(folder)["tests"] if "film" in test}


@pytest.mark.slow
def test_failing_and_known_failing_tests_are_filmed_and_linked(filmed: pytest.Pytester) -> None:
    result = filmed.runpytest_inprocess("--hri-suite=rl", "--hri-film")
    assert result.ret == 0
    made = films(filmed.path)
    written = report(filmed.path)
    assert set(made) == {test["id"] for test in written["tests"] if test["outcome"] == "known-violation"}
    assert len(made) == 2
    folder = filmed.path / "hri-report"
    assert sorted(entry.name for entry in (folder / "films").iterdir()) == sorted(
        Path(film[kind]).name for film in made.values() for kind in ("video", "strip")
    )
    film = made[BRIGHT]
    assert film["note"] == ""
    assert film["frames"] > 20
    assert len(film["times_s"]) == film["frames"]
    assert film["times_s"] == sorted(film["times_s"])
    assert film["seconds"] == pytest.approx(film["frames"] / 12, abs=0.01)
    with Image.open(folder / film["strip"]) as strip:
        assert strip.size == (3 * 640, 2 * (round(320 / 640 * 640) + 30))
    page = Page((folder / "index.html").read_text(encoding="utf-8"))
    shown = [*details(page, 0), *details(page, 1)]
    assert [test["film"] for test in shown if BRIGHT in test["nodeid"]] == [film]
    result.stdout.fnmatch_lines(["films: 2 of 2 failing tests, next to the report"])


@pytest.mark.slow
def test_without_an_encoder_the_film_is_a_gif(filmed: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pytest_hricdv.extra.film.video.has_encoder", lambda: False)
    filmed.runpytest_inprocess("--hri-suite=rl", "--hri-film", "-k", BRIGHT)
    folder = filmed.path / "hri-report"
    assert films(filmed.path)[BRIGHT]["video"] == f"films/{BRIGHT}.gif"
    with Image.open(folder / "films" / f"{BRIGHT}.gif") as gif:
        assert getattr(gif, "n_frames", 0) > 2


@pytest.mark.slow
@pytest.mark.parametrize("isolated", [(), ("--hri-isolate",)])
def test_no_more_than_a_few_failures_of_a_requirement_are_filmed_and_the_others_say_so(
    filmed: pytest.Pytester, monkeypatch: pytest.MonkeyPatch, isolated: tuple[str, ...]
) -> None:
    monkeypatch.setattr("pytest_hricdv.extra.film.film_maker.FILMS_EACH", 1)
    result = filmed.runpytest_inprocess("--hri-suite=rl", "--hri-film", *isolated)
    first, second = sorted(films(filmed.path).values(), key=lambda film: film["note"])
    assert (first["note"], second["video"]) == ("", None)
    assert second["note"].startswith("not filmed: 1 failure of R2 had been filmed in this process; ")
    result.stdout.fnmatch_lines(["films: 1 of 2 failing tests, next to the report", "  1 not filmed: *"])


@pytest.mark.slow
def test_a_camera_that_fails_costs_the_film_and_not_the_report(filmed: pytest.Pytester) -> None:
    change(filmed.path, "conftest.py", "        shade = ", "        raise OSError('no light')\n        shade = ")
    result = filmed.runpytest_inprocess("--hri-suite=rl", "--hri-film", "-k", BRIGHT)
    assert result.ret == 0
    assert films(filmed.path)[BRIGHT] == {
        "video": None,
        "strip": None,
        "seconds": None,
        "frames": 0,
        "note": "not filmed: OSError: no light",
    }
    assert list((filmed.path / "hri-report" / "films").iterdir()) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("death", "how", "mode"),
    [
        ("os.abort()", "ended by SIGABRT", ("-p", "no:xdist")),
        ("os.kill(os.getpid(), 9)", "ended by SIGKILL", ("-n", "1")),
    ],
)
def test_a_renderer_that_dies_costs_the_film_and_not_the_session(
    filmed: pytest.Pytester, death: str, how: str, mode: tuple[str, ...]
) -> None:
    change(filmed.path, "conftest.py", "        shade = ", f"        import os\n        {death}\n        shade = ")
    result = filmed.runpytest_subprocess("--hri-suite=rl", "--hri-film", "-k", BRIGHT, *mode)
    assert result.ret == 0
    assert films(filmed.path)[BRIGHT]["note"] == f"not filmed: the process with the camera {how}"
    assert list((filmed.path / "hri-report" / "films").iterdir()) == []


@pytest.mark.parametrize("mode", [(), ("-n", "2")], ids=["plain", "on two workers"])
def test_what_cannot_be_filmed_is_refused_before_the_run(lamps: pytest.Pytester, mode: tuple[str, ...]) -> None:
    result = lamps.runpytest_inprocess("--hri-suite=by-hand", "--hri-film", *mode)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    assert (
        "--hri-film: testbench 'lamps' cannot be filmed: give it simulation=Simulation(film=Film(camera=...))"
        in result.stderr.str()
    )
    assert not (lamps.path / "hri-report").exists()


def test_without_pillow_the_extra_is_named(filmed: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pytest_hricdv.extra.film.feature.find_spec", lambda name: None)
    result = filmed.runpytest_inprocess("--hri-suite=by-hand", "--hri-film")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    assert '--hri-film: Pillow is not installed: pip install "pytest-hricdv[sim]"' in result.stderr.str()


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"answer": "answer"', '"answer": "anwser"', "film moment 'answer' comes with 'anwser', neither a message nor"),
        ('"answer": "answer"', '"glare": "lamp_level"', "film moment 'glare' comes with 'lamp_level', neither"),
        ('"switched.level"', '"switched.lumen"', "film state is 'switched.lumen', which is not a field of a message"),
        ("period_s=0.1", "period_s=0", "expected a microsecond or more"),
    ],
)
def test_a_film_of_what_there_is_not_is_refused(filmed: pytest.Pytester, old: str, new: str, told: str) -> None:
    change(filmed.path, "conftest.py", old, new)
    result = filmed.runpytest_inprocess("--hri-suite=by-hand")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    assert told in result.stderr.str()
