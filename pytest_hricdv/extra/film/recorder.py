"""`FilmRecorder` takes pictures of a run at scheduled times, and keeps those that show something new, with captions.

`FilmMaker` reruns the test with a `FilmedWorld`, which stops for each picture. A caption shows simulated time,
the state of the robot, verdicts so far, and the last message or violation.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from pytest_hricdv.declarations.film import Camera
from pytest_hricdv.extra.film.schedule import END, VIOLATION, Schedule
from pytest_hricdv.extra.film.video import FRAMES_PER_S, Video
from pytest_hricdv.run import Run
from pytest_hricdv.runtime import RecordedMessage, World
from pytest_hricdv.runtime.kernel import US_PER_S

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageDraw import ImageDraw
    from PIL.ImageFont import FreeTypeFont
    from PIL.ImageFont import ImageFont as BitmapFont

BAR_PX = 72
"""Minimum height of the bar below the picture; the frame's height is a multiple of BLOCK_PX."""

BLOCK_PX = 16
"""Size of a block (pixels); encoders require frames of whole blocks."""

# Sizes of margins, frames and fonts, chosen so that captions can be read on the strip of key frames.
EDGE_PX = 12
FRAME_PX = 6
EVENT_PX = (17, 15, 13)
"""Font sizes of the last line: the largest that fits is used."""

INK, PAPER, SOFT, ALARM = (245, 245, 245), (24, 27, 33), (165, 172, 184), (214, 48, 49)
BADGES: Mapping[str, tuple[int, int, int]] = {"Passed": (30, 132, 73), "Failed": ALARM, "NC": (84, 92, 105)}

BADGES_SHARE = 0.6
"""Maximum share of a caption's width for verdicts; time and state are to the left of them."""

STILL_S = 2.0
"""While nothing changes, one frame is kept per this many simulated seconds."""

ALARM_S = 3.0
"""Simulated seconds for which a violation is shown."""

PANEL_PX = 640
COLUMNS = 3
NEVER_US = 1 << 62  # later than any run: 146,000 years


@dataclass(frozen=True)
class Caption:
    """The caption of a frame.

    Args:
        state: the state of the robot; empty if unknown.
        verdicts: requirement -> verdict so far.
        event: the last message, or the present violation.
        alarm: whether a violation is shown; the picture has a red frame.
        slow: whether the film is in slow motion.
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
        mine, theirs = (
            (caption.state, dict(caption.verdicts), caption.event, caption.alarm, caption.slow)
            for caption in (self, other)
        )
        return mine != theirs


def add_caption(picture: Image, caption: Caption) -> Image:
    """A copy of the picture with the caption in a bar below it, enlarged to whole blocks."""
    from PIL import Image, ImageDraw

    width = -(-picture.width // BLOCK_PX) * BLOCK_PX  # rounded up
    height = -(-(picture.height + BAR_PX) // BLOCK_PX) * BLOCK_PX
    frame = Image.new("RGB", (width, height), PAPER)
    frame.paste(picture, (0, 0))
    draw = ImageDraw.Draw(frame)
    if caption.alarm:
        draw.rectangle((0, 0, picture.width - 1, picture.height - 1), outline=ALARM, width=FRAME_PX)
    top = picture.height + (height - picture.height - BAR_PX) // 2 + 8
    left = _write_text(draw, (EDGE_PX, top), f"{caption.time_s:.2f} s", 24, INK)
    right = _badges(draw, (width - EDGE_PX, top + 2), caption.verdicts, BADGES_SHARE * width)
    if caption.state:
        left = max(left + 24, 150)
        _write_text(draw, (left, top), _fit_text(draw, f"robot: {caption.state}", right - left - EDGE_PX, 24), 24, INK)
    if caption.slow:  # on the picture, because the bar's first line may be full
        _label(draw, (2 * EDGE_PX, picture.height - 2 * EDGE_PX), "slow motion")
    room = width - 2 * EDGE_PX
    size = next((size for size in EVENT_PX if draw.textlength(caption.event, font=_font(size)) <= room), EVENT_PX[-1])
    event = _fit_text(draw, caption.event, room, size)
    _write_text(draw, (EDGE_PX, top + 34), event, size, INK if caption.alarm else SOFT)
    return frame


def add_title(frame: Image, title: str, width: int, *, alarm: bool) -> Image:
    """A panel of the strip: a frame scaled to a width, with a title above."""
    from PIL import Image, ImageDraw

    small = frame.resize((width, round(frame.height * width / frame.width)), Image.Resampling.LANCZOS)
    panel = Image.new("RGB", (width, small.height + 30), ALARM if alarm else PAPER)
    panel.paste(small, (0, 30))
    _write_text(ImageDraw.Draw(panel), (EDGE_PX, 5), title, 18, INK)
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
    _write_text(draw, (left + 12, bottom - 30), text, 20, INK)


def _badges(draw: ImageDraw, corner: tuple[int, int], verdicts: Mapping[str, str], room: float) -> int:
    """Write verdicts side by side, the last one into the corner; returns where they begin.

    Where there is no room for all, failed ones come first, and how many are left out is said at the left.
    """
    right, top = corner
    shown = _with_room(draw, verdicts, room)
    for name in reversed([name for name in verdicts if name in shown]):
        verdict = verdicts[name]
        text = f"{name} {verdict}"
        left = right - round(draw.textlength(text, font=_font(16))) - 16
        draw.rounded_rectangle((left, top, right, top + 24), radius=5, fill=BADGES.get(verdict, SOFT))
        _write_text(draw, (left + 8, top + 3), text, 16, INK)
        right = left - 8
    if len(shown) < len(verdicts):
        text = f"and {len(verdicts) - len(shown)} more"
        right -= round(draw.textlength(text, font=_font(16))) + 8
        _write_text(draw, (right, top + 3), text, 16, SOFT)
    return right


def _with_room(draw: ImageDraw, verdicts: Mapping[str, str], room: float) -> frozenset[str]:
    """The requirements whose badges fit side by side: the failed ones before the others."""
    widths = {name: draw.textlength(f"{name} {verdicts[name]}", font=_font(16)) + 24 for name in verdicts}
    if sum(widths.values()) <= room:
        return frozenset(verdicts)
    shown, used = set[str](), draw.textlength("and 99 more", font=_font(16)) + 8
    for name in sorted(verdicts, key=lambda name: verdicts[name] != "Failed"):
        used += widths[name]
        if used > room:
            break
        shown.add(name)
    return frozenset(shown)


def _write_text(draw: ImageDraw, place: tuple[int, int], text: str, size: int, ink: tuple[int, int, int]) -> int:
    """Write a text; returns where it ends."""
    draw.text(place, text, fill=ink, font=_font(size))
    return place[0] + round(draw.textlength(text, font=_font(size)))


def _fit_text(draw: ImageDraw, text: str, room: int, size: int) -> str:
    if draw.textlength(text, font=_font(size)) <= room:
        return text
    while text and draw.textlength(text + "...", font=_font(size)) > room:
        text = text[:-1]
    return text + "..."


@cache  # Pillow parses the font at each call
def _font(size: int) -> FreeTypeFont | BitmapFont:
    from PIL import ImageFont

    return ImageFont.load_default(size)


@dataclass(frozen=True)
class Alarm:
    """A violation to show from `time_s` (s) on."""

    time_s: float
    requirement: str
    text: str


class FilmRecorder:
    """Takes the pictures of one run.

    Args:
        camera: the camera in the world of the run.
        schedule: when to take pictures.
        run: the run whose messages and verdicts captions show.
        state: the message and field that are the robot's state, as in "state.name"; empty for none.
        alarms: violations, in the order of time.
        video: where frames go.
    """

    def __init__(
        self, camera: Camera, schedule: Schedule, run: Run, state: str, alarms: Sequence[Alarm], video: Video
    ) -> None:
        self._camera = camera
        self._schedule = schedule
        self._run = run
        self._state_topic, _, self._state_field = state.partition(".")
        self._alarms = alarms
        self._video = video
        self._left = list(reversed(schedule.times_us))
        self._keys: dict[str, Image] = {}
        self._size = (0, 0)
        self._picture: Image | None = None
        self._caption: Caption | None = None
        self.times_s: list[float] = []
        """The simulated time (s) of each frame of the video."""

    @property
    def next_us(self) -> int:
        """The time (us) of the next picture."""
        return self._left[-1] if self._left else NEVER_US

    def take_picture(self, time_us: int) -> None:
        """Take the picture that is due at the present time (us)."""
        while self._left and self._left[-1] <= time_us:
            self._left.pop()
        caption = self._captions(time_us)
        keys = [shown for shown, at in self._schedule.keys.items() if at is not None and at <= time_us]
        keys = [shown for shown in keys if shown not in self._keys and shown != END]
        for shown in keys:
            self._keys[shown] = add_caption(self._camera.picture(fine=True), caption)
        picture = self._camera.picture()
        if keys or self._is_new(picture, caption):
            frame = add_caption(picture, caption)
            self._size = frame.size
            self._video.add(frame)
            self.times_s.append(caption.time_s)
            self._picture, self._caption = picture, caption

    def end(self, time_us: int) -> None:
        """Take the last picture, at the end of the run (us). It also serves for key moments at this time."""
        last = add_caption(self._camera.picture(fine=True), self._captions(time_us))
        for shown, at in self._schedule.keys.items():
            if at is not None:
                self._keys.setdefault(shown, last)
        self._size = last.size
        for _ in range(FRAMES_PER_S):  # a second to read it
            self._video.add(last)
            self.times_s.append(time_us / US_PER_S)

    def strip(self) -> Image:
        """The key frames, from left to right and from top to bottom."""
        from PIL import Image

        panels = []
        for shown in self._schedule.keys:
            frame = self._keys.get(shown) or blank(self._size, f"no {shown}")
            panels.append(add_title(frame, shown, PANEL_PX, alarm=shown == VIOLATION and shown in self._keys))
        width, height = panels[0].size
        strip = Image.new("RGB", (width * COLUMNS, height * -(-len(panels) // COLUMNS)))
        for number, panel in enumerate(panels):
            strip.paste(panel, (number % COLUMNS * width, number // COLUMNS * height))
        return strip

    def _is_new(self, picture: Image, caption: Caption) -> bool:
        if picture is not self._picture or caption.slow or caption.differs(self._caption):
            return True
        return self._caption is None or caption.time_s - self._caption.time_s >= STILL_S

    def _captions(self, time_us: int) -> Caption:
        now_s = time_us / US_PER_S
        messages = self._run.recorder.messages
        # A monitor reports a violation at the end of the trigger; the film shows it when it happens.
        violated = {alarm.requirement: "Failed" for alarm in self._alarms if alarm.time_s <= now_s}
        alarms = [alarm.text for alarm in self._alarms if now_s - ALARM_S <= alarm.time_s <= now_s]
        others = (message for message in reversed(messages) if message.topic != self._state_topic)
        return Caption(
            time_s=now_s,
            state=self._state(messages),
            verdicts={**self._run.monitors.so_far(), **violated},
            event=alarms[-1] if alarms else _event_text(next(others, None)),
            alarm=bool(alarms),
            slow=self._schedule.is_slow(time_us),
        )

    def _state(self, messages: Sequence[RecordedMessage]) -> str:
        for message in reversed(messages):
            if message.topic == self._state_topic:
                return str(message.fields[self._state_field])
        return ""


class FilmedWorld:
    """A world that stops for pictures."""

    def __init__(self, world: World, recorder: FilmRecorder) -> None:
        self._world = world
        self._recorder = recorder

    def advance(self, target_us: int) -> int:
        """See `runtime.World`."""
        reached_us = self._world.advance(min(target_us, self._recorder.next_us))
        if reached_us >= self._recorder.next_us:
            self._recorder.take_picture(reached_us)
        return reached_us

    def observe(self) -> None:
        """See `runtime.World`."""
        self._world.observe()


def _event_text(message: RecordedMessage | None) -> str:
    if message is None:
        return ""
    values = ", ".join(f"{name} = {value}" for name, value in message.fields.items())
    return f"{message.time_s:.2f} s {message.sender}: {message.topic.replace('_', ' ')} {values}".rstrip()
