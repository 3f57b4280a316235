"""`video` opens a film file for `FilmMaker`: MP4, or GIF if there is no encoder. It is written atomically."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from pytest_hricdv._base.atomic_file import temporary_path

if TYPE_CHECKING:
    from PIL.Image import Image

FRAMES_PER_S = 12  # chosen: movement still looks smooth enough, with half as many frames to render as at 24

# Chosen: x264's own quality is 23. A film explains a run, and is kept beside many others: size counts more than edges.
QUALITY = ("-crf", "26", "-preset", "veryfast")

ENCODER_TIMEOUT_S = 60.0
"""Time limit (s) for the encoder to finish after the last frame."""

GIF_WIDTH_PX = 480
GIF_COLOURS = 64  # chosen: the scene has a dozen colours and their shades
GIF_EVERY = 2
"""A GIF has every second frame, each for twice as long: a GIF is about ten times as large as an MP4."""


class Video(Protocol):
    """A film file that is being written."""

    path: Path
    """Path of the finished file."""

    frames: int
    """Number of frames so far."""

    def add(self, frame: Image) -> None:
        """Append a frame; all have the same size. Raises OSError if it cannot be written."""

    def finish(self) -> None:
        """Complete the file and rename it. Raises OSError if it cannot be written."""

    def discard(self) -> None:
        """Remove what was written; no effect after `finish`."""


def has_encoder() -> bool:
    """True when MP4 can be written here."""
    try:
        import imageio_ffmpeg

        imageio_ffmpeg.get_ffmpeg_exe()
    except (ImportError, RuntimeError):
        return False
    return True


def video(path: Path) -> Video:
    """A film at `path`, whose suffix is added."""
    return Mp4(path.with_name(path.name + ".mp4")) if has_encoder() else Gif(path.with_name(path.name + ".gif"))


class Mp4:
    """H.264, as browsers play it; frames are sent to the encoder one by one.

    imageio-ffmpeg installs the encoder. Its writer is not used, because it does not report a failed encoder.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.frames = 0
        self._encoder: subprocess.Popen[bytes] | None = None

    def add(self, frame: Image) -> None:
        """See `Video`."""
        if self._encoder is None:
            self._encoder = self._start_encoder(frame.size)
        assert self._encoder.stdin is not None
        try:
            self._encoder.stdin.write(frame.tobytes())
        except BrokenPipeError:
            self.finish()  # raises the encoder's error
        self.frames += 1

    def finish(self) -> None:
        """See `Video`."""
        encoder, self._encoder = self._encoder, None
        if encoder is None:
            raise OSError("a film without a single frame")
        try:
            _, said = encoder.communicate(timeout=ENCODER_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            encoder.kill()
            _, said = encoder.communicate()
        if encoder.returncode != 0:
            raise OSError(f"the encoder failed ({encoder.returncode}): {said.decode(errors='replace').strip()[-200:]}")
        temporary_path(self.path).replace(self.path)

    def discard(self) -> None:
        """See `Video`."""
        if self._encoder is not None:
            self._encoder.kill()
            self._encoder.communicate()
            self._encoder = None
        temporary_path(self.path).unlink(missing_ok=True)

    def _start_encoder(self, size: tuple[int, int]) -> subprocess.Popen[bytes]:
        import imageio_ffmpeg

        raw = f"-f rawvideo -pix_fmt rgb24 -s {size[0]}x{size[1]} -r {FRAMES_PER_S} -i -".split()
        # One thread: other workers run tests. The format is given because the name of the part file does not show it.
        made = ["-c:v", "libx264", "-pix_fmt", "yuv420p", *QUALITY, "-threads", "1", "-f", "mp4"]
        return subprocess.Popen(
            [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", "-y", *raw, *made, str(temporary_path(self.path))],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
        )


class Gif:
    """A GIF of fewer, smaller frames, written by Pillow at the end."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.frames = 0
        self._kept: list[Image] = []

    def add(self, frame: Image) -> None:
        """See `Video`."""
        if self.frames % GIF_EVERY == 0:
            width = min(GIF_WIDTH_PX, frame.width)
            small = frame.resize((width, round(frame.height * width / frame.width)))
            self._kept.append(small.quantize(GIF_COLOURS))
        self.frames += 1

    def finish(self) -> None:
        """See `Video`."""
        if not self._kept:
            raise OSError("a film without a single frame")
        first, *others = self._kept
        duration_ms = 1000 * GIF_EVERY // FRAMES_PER_S
        part = temporary_path(self.path)
        first.save(part, format="GIF", save_all=True, append_images=others, duration=duration_ms, loop=0)
        part.replace(self.path)
        self._kept.clear()

    def discard(self) -> None:
        """See `Video`."""
        self._kept.clear()
        temporary_path(self.path).unlink(missing_ok=True)
