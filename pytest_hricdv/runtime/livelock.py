"""Detects livelocks (`RepetitionDetector`): a run repeats the same messages, and nothing new happens for a long time.

`RunCourse` ends such a run, which would otherwise go on to its time limit, and reports the `Cycle`. *New* is
a message, or a pair of successive messages of one sender, that has not occurred before, apart from its numbers; an
action; another value of a string signal; a numeric signal outside of its previous range. So a robot that crosses a
room, a battery that runs down, or a wait until a certain time is not a livelock.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby

from pytest_hricdv._base.message import list_names
from pytest_hricdv.runtime.kernel import Kernel
from pytest_hricdv.runtime.record import RecordedMessage, Recorder

LOOKS_EACH_S = 10.0
"""Interval of the checks (s of simulated time), which take 1 % of the processor time of a run."""

NOTHING_NEW_S = 180.0
"""A run is a livelock if nothing was new for this long (s of simulated time). People and robots of the repository's two
testbenches wait up to 150 s."""

REPEATS = 5
"""Least number of occurrences of a cycle (chosen)."""

_RANGE = 0.1
"""A number is new if it lies outside of its signal's range so far by more than this share of that range (chosen). Noise
does so ever more rarely."""

_DIGITS = re.compile(r"(?<![A-Za-z_\d])\d+")  # but not those in names, such as `Timeout1`

Token = tuple[str, str, tuple[tuple[str, object], ...]]
"""A message without its time and numbers: sender, topic, and the string and bool fields."""


@dataclass(frozen=True)
class Cycle:
    """A cycle that a run repeats.

    Args:
        since_s: the last time at which something was new (s of simulated time).
        times: number of occurrences since.
        period_s: its length (s).
        messages: the messages of one occurrence; equal successive ones are listed once.
    """

    since_s: float
    times: int
    period_s: float
    messages: tuple[str, ...]

    def __str__(self) -> str:
        often = f"{self.times} times, every {self.period_s:.3g} s"
        return f"nothing new since {self.since_s:.3f} s, and {often}: {list_names(self.messages, 8)}"


class RepetitionDetector:
    """Finds the cycle that a run repeats, from its record; it does not affect the run.

    Args:
        actions: returns the number of actions that have begun.
        is_of_code: whether a sender is the code under test.
    """

    def __init__(
        self, kernel: Kernel, recorder: Recorder, actions: Callable[[], int], is_of_code: Callable[[str], bool]
    ) -> None:
        self._kernel = kernel
        self._recorder = recorder
        self._actions = actions
        self._is_of_code = is_of_code
        self._actions_seen = 0
        self._last_new_s = 0.0
        self._messages_read = 0
        self._last: dict[str, Token] = {}
        self._pairs: set[tuple[Token | None, Token]] = set()
        self._ranges: dict[str, tuple[float, float]] = {}
        self._texts: set[tuple[str, str]] = set()
        self._changes_read: dict[str, int] = {}  # by signal

    def cycle(self, nothing_new_s: float = NOTHING_NEW_S) -> Cycle | None:
        """The cycle that the run repeats; None if something was new in the last `nothing_new_s` (s), or may be soon."""
        self._read_record()
        now_s = self._kernel.now_s
        if now_s - self._last_new_s < nothing_new_s:
            return None
        start = bisect_right(self._recorder.messages, self._last_new_s, key=lambda message: message.time_s)
        messages = self._recorder.messages[start:]
        tokens = [_token(message) for message in messages]
        counts = Counter(tokens)
        repeated = [token for token, count in counts.items() if count >= REPEATS]
        senders = Counter(token[0] for token in repeated)
        # Code that repeats one message and receives none is waiting, perhaps for a person who will come.
        is_active = any(count > 1 or not self._is_of_code(sender) for sender, count in senders.items())
        if not is_active:
            return None
        rarest = min(repeated, key=lambda token: counts[token])
        first, last = [place for place, token in enumerate(tokens) if token == rarest][-2:]
        words = tuple(_words(token, len([*same])) for token, same in groupby(tokens[first:last]))
        period_s = messages[last].time_s - messages[first].time_s
        # A wait that the cycle does not restart will end, and something else may come then.
        if self._kernel.wait_ends(now_s - 2 * period_s, now_s + nothing_new_s):
            return None
        return Cycle(self._last_new_s, counts[rarest], period_s, words)

    def _read_record(self) -> None:
        if self._actions() != self._actions_seen:
            self._actions_seen = self._actions()
            self._mark_new(self._kernel.now_s)
        for place in range(self._messages_read, len(self._recorder.messages)):
            message = self._recorder.messages[place]
            token = _token(message)
            pair = self._last.get(token[0]), token
            self._last[token[0]] = token
            if pair not in self._pairs:
                self._pairs.add(pair)
                self._mark_new(message.time_s)
        self._messages_read = len(self._recorder.messages)
        for name, times, values in self._recorder.changes():
            start = self._changes_read.get(name, 0)
            if start < len(values):
                self._changes_read[name] = len(values)
                self._read_signal(name, times, values, start)

    def _read_signal(self, name: str, times: Sequence[float], values: Sequence[float | str], start: int) -> None:
        for place in range(start, len(values)):
            value = values[place]
            if isinstance(value, str):
                is_new = (name, value) not in self._texts
                self._texts.add((name, value))
            else:
                least, most = self._ranges.get(name, (value, value))
                beyond = max(least - value, value - most)
                is_new = beyond > _RANGE * (most - least) or name not in self._ranges
                if is_new:
                    self._ranges[name] = min(least, value), max(most, value)
            if is_new:
                self._mark_new(times[place])

    def _mark_new(self, time_s: float) -> None:
        self._last_new_s = max(self._last_new_s, time_s)


def _token(message: RecordedMessage) -> Token:
    fields = tuple(
        (name, _DIGITS.sub("#", value) if isinstance(value, str) else value)
        for name, value in message.fields.items()
        if isinstance(value, str | bool)
    )
    return message.sender, message.topic, fields


def _words(token: Token, times: int) -> str:
    sender, topic, fields = token
    words = " ".join([f"{sender}: {topic}", *(f"{name}={value}" for name, value in fields)])
    return words if times == 1 else f"{words} ({times} times)"
