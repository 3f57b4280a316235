"""The README's moving picture: a generated test that fails, filmed up to the violation and a little more."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

from PIL import Image

# Chosen: the width of a README's column on the usual sites, and what keeps the file below 2 MB.
WIDTH_PX = 720
COLOURS = 128
FRAMES_PER_S = 6
RUN_S, REST_S = 6.0, 2.0
"""How long the run, and how long its last frame is shown (s)."""

AFTER_SHARE = 0.05
"""Part of the frames that come after the violation: the last one shows it, and not what follows."""


def moving_picture(film: Path, target: Path) -> None:
    """Write the picture as a GIF.

    Args:
        film: an MP4 of `--hri-film`, in which there is a violation.
        target: the GIF.
    """
    frames = _frames(film)
    violation = next(number for number, frame in enumerate(frames) if _is_alarm(frame))
    pictures = [frame for number, frame in enumerate(frames) if number in _shown(violation)]
    palette = _montage([pictures[0], frames[violation], pictures[-1]]).quantize(COLOURS)
    first, *others = (picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures)
    durations_ms = [round(1000 / FRAMES_PER_S)] * len(pictures)
    durations_ms[-1] += round(1000 * REST_S)
    first.save(target, format="GIF", save_all=True, append_images=others, duration=durations_ms, loop=0, optimize=True)
    print(f"{target}: {target.stat().st_size // 1024} KiB, {sum(durations_ms) / 1000:.1f} s")


def _shown(violation_frame: int) -> set[int]:
    """The numbers of the frames that are shown: all around the violation, so that it is in slow motion."""
    number = round(RUN_S * FRAMES_PER_S)
    after = round(AFTER_SHARE * number)
    return {max(0, violation_frame - 2 * place) for place in range(number - after)} | {
        violation_frame + 2 * place for place in range(1, after + 1)
    }


def _frames(film: Path) -> list[Image.Image]:
    """The frames of a film, WIDTH_PX wide."""
    import imageio_ffmpeg

    with tempfile.TemporaryDirectory() as folder:
        decoder = [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", "-i", str(film)]
        scaled = [
            "-vf",
            f"scale={WIDTH_PX}:-2:flags=lanczos",
            f"{folder}/%05d.png",
        ]  # -2: an even height, in proportion
        subprocess.run([*decoder, *scaled], check=True)
        return [Image.open(path).convert("RGB") for path in sorted(Path(folder).iterdir())]


def _is_alarm(frame: Image.Image) -> bool:
    """True where the film has framed its picture in red, as it does while it shows a violation."""
    pixel = frame.convert("RGB").getpixel((1, 1))
    assert isinstance(pixel, tuple)
    red, green, blue = pixel
    return red > 2 * max(green, blue)


def _montage(pictures: Sequence[Image.Image]) -> Image.Image:
    """One above the other: one palette for all frames, without which colours would flicker."""
    whole = Image.new("RGB", (pictures[0].width, sum(picture.height for picture in pictures)))
    top = 0
    for picture in pictures:
        whole.paste(picture, (0, top))
        top += picture.height
    return whole
