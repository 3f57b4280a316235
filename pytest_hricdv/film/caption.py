"""Captions of pictures: simulated time, the robot's state, verdicts so far, the last message or violation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageDraw import ImageDraw
    from PIL.ImageFont import FreeTypeFont
    from PIL.ImageFont import ImageFont as BitmapFont

BAR_PX = 72
"""Minimum height of the bar below the picture; the frame's height is a multiple of BLOCK_PX."""

BLOCK_PX = 16
"""Encoders require frames of whole blocks."""

EDGE_PX = 12
FRAME_PX = 6
EVENT_PX = (17, 15, 13)
"""Font sizes of the last line: the largest that fits is used."""

INK, PAPER, SOFT, ALARM = (245, 245, 245), (24, 27, 33), (165, 172, 184), (214, 48, 49)
BADGES: Mapping[str, tuple[int, int, int]] = {"Passed": (30, 132, 73), "Failed": ALARM, "NC": (84, 92, 105)}


@dataclass(frozen=True)
class Caption:
    """The caption of a frame.

    Args:
        time_s: simulated time (s).
        state: of the robot; empty if unknown.
        verdicts: requirement -> verdict so far.
        event: the last message, or the present violation.
        alarm: a violation is shown; the picture has a red frame.
        slow: the film is in slow motion.
    """

    time_s: float
    state: str
    verdicts: Mapping[str, str]
    event: str
    alarm: bool = False
    slow: bool = False

    def differs(self, other: Caption | None) -> bool:
        """True if more than the time has changed."""
        if other is None:
            return True
        mine, theirs = ((each.state, dict(each.verdicts), each.event, each.alarm, each.slow) for each in (self, other))
        return mine != theirs


def captioned(picture: Image, caption: Caption) -> Image:
    """A copy of the picture with the caption in a bar below it, enlarged to whole blocks."""
    from PIL import Image, ImageDraw

    width = -(-picture.width // BLOCK_PX) * BLOCK_PX
    height = -(-(picture.height + BAR_PX) // BLOCK_PX) * BLOCK_PX
    frame = Image.new("RGB", (width, height), PAPER)
    frame.paste(picture, (0, 0))
    draw = ImageDraw.Draw(frame)
    if caption.alarm:
        draw.rectangle((0, 0, picture.width - 1, picture.height - 1), outline=ALARM, width=FRAME_PX)
    top = picture.height + (height - picture.height - BAR_PX) // 2 + 8
    left = _written(draw, (EDGE_PX, top), f"{caption.time_s:.2f} s", 24, INK)
    right = _badges(draw, (width - EDGE_PX, top + 2), caption.verdicts)
    if caption.state:
        left = max(left + 24, 150)
        _written(draw, (left, top), _fitting(draw, f"robot: {caption.state}", right - left - EDGE_PX, 24), 24, INK)
    if caption.slow:  # on the picture, because the bar's first line may be full
        _label(draw, (2 * EDGE_PX, picture.height - 2 * EDGE_PX), "slow motion")
    room = width - 2 * EDGE_PX
    size = next((size for size in EVENT_PX if draw.textlength(caption.event, font=_font(size)) <= room), EVENT_PX[-1])
    event = _fitting(draw, caption.event, room, size)
    _written(draw, (EDGE_PX, top + 34), event, size, INK if caption.alarm else SOFT)
    return frame


def titled(frame: Image, title: str, width: int, *, alarm: bool) -> Image:
    """A panel of the strip: a frame scaled to a width, with a title above."""
    from PIL import Image, ImageDraw

    small = frame.resize((width, round(frame.height * width / frame.width)), Image.Resampling.LANCZOS)
    panel = Image.new("RGB", (width, small.height + 30), ALARM if alarm else PAPER)
    panel.paste(small, (0, 30))
    _written(ImageDraw.Draw(panel), (EDGE_PX, 5), title, 18, INK)
    return panel


def blank(size: tuple[int, int], text: str) -> Image:
    """A frame for a moment that did not happen."""
    from PIL import Image, ImageDraw

    frame = Image.new("RGB", size, PAPER)
    draw = ImageDraw.Draw(frame)
    draw.text((size[0] / 2, size[1] / 2), text, fill=SOFT, font=_font(32), anchor="mm")
    return frame


def _label(draw: ImageDraw, corner: tuple[int, int], text: str) -> None:
    """Write a text on the picture, up and right from a corner."""
    left, bottom = corner
    right = left + 24 + round(draw.textlength(text, font=_font(20)))
    draw.rounded_rectangle((left, bottom - 34, right, bottom), radius=6, fill=PAPER)
    _written(draw, (left + 12, bottom - 30), text, 20, INK)


def _badges(draw: ImageDraw, corner: tuple[int, int], verdicts: Mapping[str, str]) -> int:
    """Write verdicts side by side, the last one into the corner; returns where they begin."""
    right, top = corner
    for name, verdict in reversed(list(verdicts.items())):
        text = f"{name} {verdict}"
        left = right - round(draw.textlength(text, font=_font(16))) - 16
        draw.rounded_rectangle((left, top, right, top + 24), radius=5, fill=BADGES.get(verdict, SOFT))
        _written(draw, (left + 8, top + 3), text, 16, INK)
        right = left - 8
    return right


def _written(draw: ImageDraw, place: tuple[int, int], text: str, size: int, ink: tuple[int, int, int]) -> int:
    """Write a text; returns where it ends."""
    draw.text(place, text, fill=ink, font=_font(size))
    return place[0] + round(draw.textlength(text, font=_font(size)))


def _fitting(draw: ImageDraw, text: str, room: int, size: int) -> str:
    if draw.textlength(text, font=_font(size)) <= room:
        return text
    while text and draw.textlength(text + "...", font=_font(size)) > room:
        text = text[:-1]
    return text + "..."


@cache
def _font(size: int) -> FreeTypeFont | BitmapFont:
    from PIL import ImageFont

    return ImageFont.load_default(size)
