"""The README's moving picture is cut around the violation, and lasts eight seconds."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from PIL import Image

from studies.moving_picture import moving_picture

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
def test_it_ends_on_the_violation(tmp_path: Path) -> None:
    target = tmp_path / "run.gif"
    moving_picture(film(tmp_path / "film.mp4", frames=100, violation=70), target)
    with Image.open(target) as picture:
        frames = []
        for number in range(getattr(picture, "n_frames", 1)):
            picture.seek(number)
            middle = picture.convert("RGB").getpixel((5, 300))
            assert isinstance(middle, tuple)
            frames.append((middle, picture.info["duration"]))
    assert sum(duration for _, duration in frames) == pytest.approx(8_000, rel=0.05)
    colours = ["red" if pixel[0] > 2 * pixel[1] else "grey" for pixel, _ in frames]
    assert list(dict.fromkeys(colours)) == ["grey", "red"]
    assert frames[-1][1] > 2_000
