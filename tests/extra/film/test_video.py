"""Film files: readable, of the right length, complete or not there at all."""

from __future__ import annotations

from pathlib import Path

import pytest
from PIL import Image

from pytest_hricdv.extra.film.recorder import Caption, add_caption
from pytest_hricdv.extra.film.video import FRAMES_PER_S, Mp4, Video, video
from tests.extra.film.decoded import about, decoded

SIZE = (320, 160)


def frame(number: int) -> Image.Image:
    """Frames that differ."""
    return Image.new("RGB", SIZE, (10 * number, 100, 200 - 10 * number))


def filmed(made: Video, frames: int) -> Path:
    """A film of so many frames."""
    for number in range(frames):
        made.add(frame(number))
    made.finish()
    assert made.frames == frames
    return made.path


def test_an_mp4_has_every_frame_in_a_form_that_browsers_play(tmp_path: Path) -> None:
    path = filmed(video(tmp_path / "a.test-1"), 15)
    assert path == tmp_path / "a.test-1.mp4"
    pictures = decoded(path, SIZE)
    assert len(pictures) == 15
    assert pictures[14].getpixel((0, 0)) == pytest.approx((140, 100, 60), abs=8)
    told = about(path)
    assert "Video: h264" in told
    assert "yuv420p" in told
    assert f"{SIZE[0]}x{SIZE[1]}" in told
    assert f"{FRAMES_PER_S} fps" in told
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.test-1.mp4"]


def test_an_encoder_that_fails_is_an_error_with_its_own_words(tmp_path: Path) -> None:
    made = Mp4(tmp_path / "missing" / "film.mp4")
    with pytest.raises(OSError, match=r"(?s)the encoder failed .*No such file"):
        filmed(made, 40)
    made.discard()


def test_without_an_encoder_there_is_a_gif(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pytest_hricdv.extra.film.video.has_encoder", lambda: False)
    path = filmed(video(tmp_path / "test-1"), 15)
    assert path == tmp_path / "test-1.gif"
    with Image.open(path) as gif:
        assert (gif.format, gif.size, getattr(gif, "n_frames", 0)) == ("GIF", SIZE, 8)
        assert gif.info["duration"] == pytest.approx(2000 / FRAMES_PER_S, abs=10)
        assert gif.info["loop"] == 0


@pytest.mark.parametrize("size", [(960, 432), (481, 203), (16, 16)])
def test_a_frame_has_whole_blocks_and_leaves_its_picture_untouched(size: tuple[int, int]) -> None:
    picture = Image.new("RGB", size, (1, 2, 3))
    before = picture.tobytes()
    caption = Caption(1.0, "Reset", {"R1": "NC", "R2": "Failed"}, "a very long message " * 40, alarm=True, slow=True)
    result = add_caption(picture, caption)
    assert picture.tobytes() == before
    assert (result.width % 16, result.height % 16) == (0, 0)
    assert result.height >= size[1] + 64
    assert result.getpixel((size[0] // 2, 1)) == (214, 48, 49)
    assert add_caption(picture, Caption(1.0, "", {}, "")).getpixel((0, 0)) == (1, 2, 3)
