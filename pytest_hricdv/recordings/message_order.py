"""`MessageOrder` sorts recorded messages by time, in bounded memory; `RecordingReader` uses it.

Times are the recorder's, or those of a simulation's `/clock` (`times_of_clock`).
"""

from __future__ import annotations

import heapq
import math
import struct
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple, NoReturn

from pytest_hricdv.recordings.bags import Value
from pytest_hricdv.recordings.containers import UnreadableError

CLOCK = "/clock"
NS_PER_S = 1_000_000_000

JITTER_S = 1.0
"""Maximum disorder of messages (s), as from recorders with a cache; with more, the clock was set back."""

HEADER_JITTER_S = 5.0
"""Maximum disorder of stamps in headers (s; chosen): processing an image takes a second or two."""

PAUSE_S = 600.0
"""A longer pause (s) of all topics is a jump of the clock, or the beginning of another recording."""

MAX_VALUES = 3_000_000
"""Maximum number of messages and field values in memory, which take 500 MB."""

MAX_PARTS = 1000
"""Maximum number of jumps of the clock; with more, a log is treated as without clock."""


class RecordedSample(NamedTuple):
    """A message: its time (s), topic and fields, which are empty unless they were asked for."""

    time_s: float
    topic: str
    fields: Mapping[str, Value]


NOTHING: Mapping[str, Value] = {}
UNREAD: Mapping[str, Value] = {}
"""The fields of a message that could not be read; compared by identity."""

TICK = ""
"""In a `RecordedSample`: stands for the topic `/clock`."""


def clock_s(data: bytes) -> float:
    seconds, nanoseconds = struct.unpack_from("<iI", data, 4)
    return float(seconds + nanoseconds / NS_PER_S)


MAX_HELD = 100_000
"""Maximum number of messages kept until the next message of `/clock`, also until the first one."""


def times_of_clock(samples: Iterable[RecordedSample]) -> Iterator[RecordedSample]:
    """The messages with times of the clock of the simulation, interpolated between its messages.

    If its first message comes late in the recording, earlier ones keep the time of the recorder.
    """
    held: list[RecordedSample] = []
    ticks: list[tuple[float, float]] = []
    is_waiting = True
    for sample in samples:
        if sample.topic == TICK:
            ticks = [*ticks[-1:], (sample.time_s, float(sample.fields[""]))]  # type: ignore[arg-type]
            if len(ticks) > 1 or not is_waiting:
                yield from _between(held, ticks)
                held = []
            is_waiting = True
        elif is_waiting:
            held.append(sample)
            if len(held) > MAX_HELD:
                yield from _between(held, ticks)
                held, is_waiting = [], bool(ticks)
        else:
            yield sample
    yield from _between(held, ticks)


def _between(held: Iterable[RecordedSample], ticks: Sequence[tuple[float, float]]) -> Iterator[RecordedSample]:
    if not ticks:
        yield from held
        return
    (before_s, from_s), (after_s, to_s) = ticks[0], ticks[-1]
    width_s = after_s - before_s if to_s >= from_s else 0.0
    for sample in held:
        share = min(max((sample.time_s - before_s) / width_s, 0.0), 1.0) if width_s > 0 else 0.0
        yield RecordedSample(from_s + share * (to_s - from_s), sample.topic, sample.fields)


class MessageOrder:
    """Puts messages into the order of time. A message waits until no later one can precede it.

    Nearly all come in order, so a queue is kept and only late ones are in a heap.

    Args:
        jitter_s: greatest disorder of messages.
        splits: whether the clock may jump, which begins another part.
    """

    def __init__(self, name: str, jitter_s: float, *, splits: bool) -> None:
        self._name, self._jitter_s, self._splits = name, jitter_s, splits
        self._part = self._number = self._more = 0
        self._last_s = math.nan
        self._waiting: deque[RecordedSample] = deque()  # in order
        self._late: list[tuple[float, int, RecordedSample]] = []  # a heap
        self._jumps: list[str] = []

    def add(self, sample: RecordedSample) -> Iterable[tuple[int, RecordedSample]]:
        """Add the next message; returns those that nothing can precede any more."""
        time_s, waiting = sample.time_s, self._waiting
        self._number += 1
        step_s = time_s - self._last_s
        if step_s >= 0.0 and (step_s <= PAUSE_S or not self._splits):
            self._last_s = time_s
            waiting.append(sample)
            if waiting[0].time_s >= time_s - self._jitter_s and not self._late:
                return () if len(waiting) < MAX_VALUES else self._overflow()
            return self._due(time_s - self._jitter_s)
        return self._add_late(sample)

    def _add_late(self, sample: RecordedSample) -> Iterator[tuple[int, RecordedSample]]:
        if self._number == 1:
            self._last_s = sample.time_s
            self._waiting.append(sample)
        elif self._splits and not -self._jitter_s <= sample.time_s - self._last_s <= PAUSE_S:
            yield from self.rest()
            self._jump(sample)
            self._waiting.append(sample)
        else:
            heapq.heappush(self._late, (sample.time_s, self._number, sample))
            if len(self._late) > MAX_VALUES:
                self._overflow()

    def _overflow(self) -> NoReturn:
        raise UnreadableError(f"{self._name}: has more than {MAX_VALUES:,} messages in {self._jitter_s:g} s")

    def _due(self, before_s: float) -> Iterator[tuple[int, RecordedSample]]:
        waiting, late, part = self._waiting, self._late, self._part
        while waiting and waiting[0].time_s < before_s:
            if late and late[0][0] < waiting[0].time_s:
                yield part, heapq.heappop(late)[2]
            else:
                yield part, waiting.popleft()
        while late and late[0][0] < before_s:
            yield part, heapq.heappop(late)[2]

    def rest(self) -> Iterator[tuple[int, RecordedSample]]:
        """The messages that still wait."""
        yield from self._due(math.inf)

    def _jump(self, sample: RecordedSample) -> None:
        jump_s = sample.time_s - self._last_s
        how = f"goes back by {-jump_s:.3g} s" if jump_s < 0 else f"jumps by {jump_s:.3g} s"
        self._part += 1
        self._last_s = sample.time_s
        if self._part >= MAX_PARTS:
            raise UnreadableError(f"{self._name}: its clock jumps more than {MAX_PARTS:,} times")
        if len(self._jumps) < 3:
            at = f"{self._name}: message {self._number} ({sample.topic})"
            self._jumps.append(f"{at}: the clock {how}: times across it are not counted")
        else:
            self._more += 1

    def jumps(self) -> list[str]:
        """The first jumps, a sentence each, and the number of further ones."""
        return [*self._jumps, *([f"{self._name}: {self._more} more"] if self._more else [])]
