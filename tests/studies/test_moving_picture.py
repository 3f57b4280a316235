"""The README's moving picture is cut around the violation, and lasts ten seconds."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from PIL import Image

from studies.moving_picture import PAPER, card, moving_picture
from studies.screenshots import first_cause

GREY, RED = (120, 120, 120), (214, 48, 49)
SIZE = (320, 160)


def film(target: Path, *, frames: int, violation: int) -> Path:
    """A film that is grey, and red as soon as there is a violation."""
    encoder = pytest.importorskip("imageio_ffmpeg").get_ffmpeg_exe()
    raw = b"".join(bytes(RED if number >= violation else GREY) * (SIZE[0] * SIZE[1]) for number in range(frames))
    made = f"-v error -f rawvideo -pix_fmt rgb24 -s {SIZE[0]}x{SIZE[1]} -r 12 -i - -pix_fmt yuv420p {target}"
    subprocess.run([encoder, *made.split()], input=raw, check=True)
    return target


@pytest.mark.slow  # an encoder and a decoder run
def test_it_shows_the_violation_then_the_cause(tmp_path: Path) -> None:
    target = tmp_path / "run.gif"
    moving_picture(film(tmp_path / "film.mp4", frames=100, violation=70), ["1 test fails for 1 cause"], target)
    with Image.open(target) as picture:
        frames = []
        for number in range(getattr(picture, "n_frames", 1)):
            picture.seek(number)
            middle = picture.convert("RGB").getpixel((5, 300))
            assert isinstance(middle, tuple)
            frames.append((middle, picture.info["duration"]))
    assert sum(duration for _, duration in frames) == pytest.approx(10_000, rel=0.05)
    colours = ["red" if pixel[0] > 2 * pixel[1] else "dark" if sum(pixel) < 100 else "grey" for pixel, _ in frames]
    assert list(dict.fromkeys(colours)) == ["grey", "red", "dark"]


def test_a_long_line_of_the_card_is_wrapped_and_too_many_are_left_out() -> None:
    picture = card(["a headline", *["word " * 40] * 50], (400, 200))
    assert picture.size == (400, 200)
    edge = picture.crop((385, 0, 400, 200))
    assert edge.getcolors() == [(15 * 200, PAPER)]


PRINTED = """..F
hricdv: looking for the causes of 2 failing tests, in at most 6 runs ...
===== what tests fail for =====
2 tests fail for 2 causes
cause 1 (866391c5): R3 in 1 test
  at controller/fetching.py:43 in grasp, 0.32: hand.close()
  pytest --hri-replay=/somewhere/hri-report/failures/a.json
  a  R3  /somewhere/hri-report/failures/a.json
cause 2 (766391c5): R4 in 1 test
"""


@pytest.mark.parametrize("folder", ["/somewhere/", "../../../somewhere/", ""])
def test_the_card_says_what_the_terminal_said_of_the_first_cause(folder: str) -> None:
    assert first_cause(PRINTED.replace("/somewhere/", folder)) == [
        "2 tests fail for 2 causes",
        "cause 1 (866391c5): R3 in 1 test",
        "  at controller/fetching.py:43 in grasp, 0.32: hand.close()",
        "  pytest --hri-replay=hri-report/failures/a.json",
    ]
