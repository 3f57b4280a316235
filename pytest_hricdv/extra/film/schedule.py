"""`schedule`: decides at which simulated times of a run `FilmMaker` takes pictures, and which of them are key frames.

All times are known beforehand, since the film is of a run that is repeated.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pytest_hricdv.runtime.kernel import US_PER_S

FRAMES = 240
"""Approximate number of pictures at regular intervals: 20 s of film at 12 a second; longer runs are shown faster."""

SHORTEST_STEP_S = 0.2  # minimum simulated time between pictures, for short runs
SLOW_BEFORE_S, SLOW_AFTER_S = 0.5, 1.5
"""Simulated seconds before and after a violation in which a picture is taken each period, which gives slow motion."""

SLOW_VIOLATIONS = 3
"""Number of violations in slow motion, the first ones: a run can have hundreds."""

VIOLATION, END = "violation", "end"
"""Names of the key frames that each film has besides those of the interaction (`Film.moments`)."""


@dataclass(frozen=True)
class Moment:
    """A key frame: what it shows, and when (s); None if it did not happen."""

    shows: str
    time_s: float | None


@dataclass(frozen=True)
class Schedule:
    """The times (us) at which pictures are taken, and the key frames among them: shown -> time, or None without.

    The last key frame is the end of the run.
    """

    times_us: tuple[int, ...]
    keys: Mapping[str, int | None]
    slow: tuple[tuple[int, int], ...] = ()

    def is_slow(self, time_us: int) -> bool:
        """True around a violation."""
        return any(begin <= time_us <= end for begin, end in self.slow)


def key_moments(
    moments: Mapping[str, str], events: Sequence[tuple[float, str]], violation_s: float | None, end_s: float
) -> list[Moment]:
    """The key frames of one interaction, in the order of time: the one with the first violation, else the first one.

    Args:
        moments: shown -> the event that it comes with, in the order in which they come in an interaction.
        events: the run's events, as (time in s, name), in the order of time.
        violation_s: when the first violation was, if there was one.
    """
    frames: list[Moment] = []
    after_s, until_s = 0.0, end_s
    for shown, event in moments.items():
        times = [time_s for time_s, name in events if name == event]
        if not frames:  # an interaction lasts from one such event to the next
            begun = [time_s for time_s in times if violation_s is None or time_s <= violation_s]
            first_s = begun[0 if violation_s is None else -1] if begun else None
            if first_s is not None:
                after_s = first_s
                until_s = min((time_s for time_s in times if time_s > first_s), default=end_s)
            frames.append(Moment(shown, first_s))
            continue
        first_s = next((time_s for time_s in times if after_s <= time_s <= until_s), None)
        after_s = after_s if first_s is None else first_s
        frames.append(Moment(shown, first_s))
    place = next((i for i, frame in enumerate(frames) if _later(frame, violation_s)), len(frames))
    return [*frames[:place], Moment(VIOLATION, violation_s), *frames[place:], Moment(END, end_s)]


def _later(moment: Moment, than_s: float | None) -> bool:
    return than_s is not None and moment.time_s is not None and moment.time_s > than_s


def schedule(moments: Sequence[Moment], violations_s: Sequence[float], end_s: float, period_us: int) -> Schedule:
    """The times of all pictures.

    Args:
        moments: the key frames; the last one is the end.
        violations_s: when violations were.
        period_us: pictures are taken at multiples of this.
    """
    end_us = round(end_s * US_PER_S)
    wanted_us = max(SHORTEST_STEP_S * US_PER_S, end_us / FRAMES)
    step_us = max(1, round(wanted_us / period_us)) * period_us
    times = set(range(0, end_us, step_us))
    slow = [_slow(time_s, period_us, end_us) for time_s in sorted(violations_s)[:SLOW_VIOLATIONS]]
    for begin, end in slow:
        times.update(range(begin, end, period_us))  # a set: a time of both kinds is one picture
    keys: dict[str, int | None] = {}
    for moment in moments[:-1]:
        time_us = None if moment.time_s is None else _next(moment.time_s, period_us)
        keys[moment.shows] = time_us if time_us is None or time_us < end_us else end_us
        times.update([time_us] if time_us is not None and time_us < end_us else [])
    return Schedule(tuple(sorted(times)), keys | {moments[-1].shows: end_us}, tuple(slow))


def _next(time_s: float, period_us: int) -> int:
    """The first multiple of the period after a time."""
    return (round(time_s * US_PER_S) // period_us + 1) * period_us


def _slow(time_s: float, period_us: int, end_us: int) -> tuple[int, int]:
    begin = max(0, _next(time_s - SLOW_BEFORE_S, period_us))
    return begin, min(end_us, _next(time_s + SLOW_AFTER_S, period_us))
