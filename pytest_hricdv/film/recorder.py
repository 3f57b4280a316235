"""Records a film: takes pictures of a run at the scheduled times, and keeps those that show something new."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from pytest_hricdv.film.caption import Caption, blank, captioned, titled
from pytest_hricdv.film.film import END, US_PER_S, VIOLATION, Camera, Schedule
from pytest_hricdv.film.video import FRAMES_PER_S, Video
from pytest_hricdv.runtime import RecordedMessage, World

if TYPE_CHECKING:
    from PIL.Image import Image

STILL_S = 2.0
"""While nothing changes, one frame is kept per this many simulated seconds."""

ALARM_S = 3.0
"""Simulated seconds for which a violation is shown."""

PANEL_PX = 640
COLUMNS = 3
NEVER_US = 1 << 62


class RunView(Protocol):
    """What captions show of a run: its messages and verdicts so far."""

    def messages(self) -> Sequence[RecordedMessage]: ...

    def verdicts(self) -> Mapping[str, str]: ...


@dataclass(frozen=True)
class Alarm:
    """A violation to show from `time_s` (s) on."""

    time_s: float
    requirement: str
    text: str


class FilmRecorder:
    """Takes the pictures of one run.

    Args:
        camera: in the world of the run.
        schedule: when to take pictures.
        view: messages and verdicts for captions.
        state: the message and field that are the robot's state, as in "state.name"; empty for none.
        alarms: violations, in the order of time.
        video: where frames go.
    """

    def __init__(
        self, camera: Camera, schedule: Schedule, view: RunView, state: str, alarms: Sequence[Alarm], video: Video
    ) -> None:
        self._camera = camera
        self._schedule = schedule
        self._view = view
        self._state_topic, _, self._state_field = state.partition(".")
        self._alarms = alarms
        self._video = video
        self._left = list(reversed(schedule.times_us))
        self._keys: dict[str, Image] = {}
        self._size = (0, 0)
        self._picture: Image | None = None
        self._caption: Caption | None = None

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
            self._keys[shown] = captioned(self._camera.picture(fine=True), caption)
        picture = self._camera.picture()
        if keys or self._is_new(picture, caption):
            frame = captioned(picture, caption)
            self._size = frame.size
            self._video.add(frame)
            self._picture, self._caption = picture, caption

    def end(self, time_us: int) -> None:
        """Take the last picture, at the end of the run (us). It also serves for key moments at this time."""
        last = captioned(self._camera.picture(fine=True), self._captions(time_us))
        for shown, at in self._schedule.keys.items():
            if at is not None:
                self._keys.setdefault(shown, last)
        self._size = last.size
        for _ in range(FRAMES_PER_S):  # a second to read it
            self._video.add(last)

    def strip(self) -> Image:
        """The key frames, from left to right and from top to bottom."""
        from PIL import Image

        panels = []
        for shown in self._schedule.keys:
            frame = self._keys.get(shown) or blank(self._size, f"no {shown}")
            panels.append(titled(frame, shown, PANEL_PX, alarm=shown == VIOLATION and shown in self._keys))
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
        messages = self._view.messages()
        # A monitor reports a violation at the end of the attempt; the film shows it when it happens.
        violated = {alarm.requirement: "Failed" for alarm in self._alarms if alarm.time_s <= now_s}
        alarms = [alarm.text for alarm in self._alarms if now_s - ALARM_S <= alarm.time_s <= now_s]
        others = (message for message in reversed(messages) if message.topic != self._state_topic)
        return Caption(
            time_s=now_s,
            state=self._state(messages),
            verdicts={**self._view.verdicts(), **violated},
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
