"""Films read back."""

from __future__ import annotations

import subprocess
from pathlib import Path

from PIL import Image


def decoded(path: Path, size: tuple[int, int]) -> list[Image.Image]:
    """The frames of an MP4 whose frames are known to have this size."""
    import imageio_ffmpeg

    command = [
        imageio_ffmpeg.get_ffmpeg_exe(),
        "-v",
        "error",
        "-i",
        str(path),
        "-f",
        "rawvideo",
        "-pix_fmt",
        "rgb24",
        "-",
    ]
    pixels = subprocess.run(command, capture_output=True, check=True, timeout=60).stdout
    frame = size[0] * size[1] * 3
    assert len(pixels) % frame == 0
    return [Image.frombytes("RGB", size, pixels[start : start + frame]) for start in range(0, len(pixels), frame)]


def about(path: Path) -> str:
    """What the decoder says of an MP4: length, codec, size, rate."""
    import imageio_ffmpeg

    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-hide_banner", "-i", str(path), "-f", "null", "-"]
    return subprocess.run(command, capture_output=True, check=True, timeout=60).stderr.decode()
