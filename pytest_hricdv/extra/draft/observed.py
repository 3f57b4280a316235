"""Observations in recordings: ranges of numbers, and texts."""

from __future__ import annotations

import math
import re
from collections import Counter, defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from pytest_hricdv.recordings.message_order import RecordedSample
from pytest_hricdv.recordings.recording import Recording

MARGIN = 0.1
"""Share of its width by which a range is wider than what was observed, at each end."""

MIN_OBSERVATIONS = 10
"""Observations that make a range; with fewer, it is a question. The next value lies outside the extremes of n
observations with a chance of 2 / (n + 1), whatever their distribution: 18 % with 10."""


MAX_TEXTS = 8
"""A field with more texts than this is no choice among a few."""


def key_of(topic: str) -> str:
    """A topic as drafts and requirements call it.

    >>> key_of("/arm/moving")
    'arm_moving'
    """
    return re.sub(r"[^a-z0-9]+", "_", topic.lower()).strip("_")


@dataclass(frozen=True)
class Spread:
    """Observed numbers.

    Args:
        count: of them.
        low: the least one.
        high: the greatest one.
        low_5: below it are 5 % of them.
        high_95: above it are 5 %.
        source: the files that they are of.
        is_complete: whether all are whole numbers.
    """

    count: int
    low: float
    high: float
    low_5: float
    high_95: float
    source: str
    is_complete: bool = False

    @property
    def is_trusted(self) -> bool:
        """Whether there are enough for a range."""
        return self.count >= MIN_OBSERVATIONS

    def ends(self, *, whole: bool = False) -> tuple[float, float]:
        """A range with the margin; not below 0 where nothing was.

        Args:
            whole: whether only whole numbers are possible: then there is no margin.
        """
        margin = 0.0 if whole else MARGIN * (self.high - self.low)
        low, high = _round(self.low - margin, up=False), _round(self.high + margin, up=True)
        return (max(low, 0.0) if self.low >= 0 else low), (min(high, 0.0) if self.high <= 0 else high)

    def comment(self, unit: str = "", of: str = "messages", *, whole: bool = False) -> str:
        """The source of the range: `observed 0.4 to 3.2 s in 41 messages of run.mcap`."""
        unit = f" {unit}" if unit else ""
        inner = f" (5 to 95 %: {self.low_5:.3g} to {self.high_95:.3g})" if self.is_trusted else ""
        margin = "" if whole or self.low == self.high else f"; margin {MARGIN * 100:g} %"
        of = of.removesuffix("s") if self.count == 1 else of
        text = f"observed {self.low:.3g} to {self.high:.3g}{unit}{inner} in {self.count} {of} of {self.source}{margin}"
        return text if self.is_trusted else f"TODO: {text}: too few to trust"


def _round(value: float, *, up: bool) -> float:
    """A number with three digits, upwards or downwards."""
    if value == 0:
        return 0.0
    step = 10.0 ** (math.floor(math.log10(abs(value))) - 2)
    steps = math.ceil(value / step - 1e-9) if up else math.floor(value / step + 1e-9)
    return float(f"{steps * step:.12g}")


def spread(values: Collection[float], source: str) -> Spread | None:
    """The spread of numbers, of which those that are not finite do not count; None if there are none."""
    ordered = sorted(value for value in values if math.isfinite(value))
    if not ordered:
        return None
    last = len(ordered) - 1
    low, high = ordered[round(0.05 * last)], ordered[round(0.95 * last)]
    is_complete = all(value == int(value) for value in ordered)
    return Spread(len(ordered), ordered[0], ordered[-1], low, high, source, is_complete)


@dataclass(frozen=True)
class ObservedTopic:
    """Observations of a topic.

    Args:
        name: as it was recorded.
        count: of its messages.
        numbers: path of a field -> its numbers, those of all elements of an array.
        texts: path of a field -> how often each text, or truth, was observed.
    """

    name: str
    count: int
    numbers: dict[str, Spread]
    texts: dict[str, Counter[str]]


@dataclass(frozen=True)
class Observation:
    """Observations in recordings.

    Args:
        source: the names of the files.
        topics: key of a topic (`arm_moving`) -> its observations.
    """

    source: str
    topics: dict[str, ObservedTopic] = field(default_factory=dict)

    def rename(self, names: Mapping[str, str]) -> Observation:
        """The observation with other keys of topics."""
        return Observation(self.source, {names.get(key, key): topic for key, topic in self.topics.items()})


def observe(recordings: Sequence[Recording]) -> Observation:
    """Merge the observations of recordings."""
    source = ", ".join(dict.fromkeys(recording.name for recording in recordings if recording.parts))
    if len(recordings) > 2:
        source = f"{len(recordings)} recordings"
    messages: dict[str, list[RecordedSample]] = defaultdict(list)
    for message in (message for recording in recordings for part in recording.parts for message in part):
        messages[key_of(message.topic)].append(message)
    topics = {key: ObservedTopic(own[0].topic, len(own), _numbers(own, source), _texts(own))
              for key, own in messages.items()}  # fmt: skip
    return Observation(source, topics)


def _numbers(messages: Sequence[RecordedSample], source: str) -> dict[str, Spread]:
    values: dict[str, list[float]] = defaultdict(list)
    for message in messages:
        for path, value in message.fields.items():
            if isinstance(value, tuple):
                values[path] += value
            elif isinstance(value, float):
                values[path].append(value)
    spreads = {path: spread(numbers, source) for path, numbers in values.items()}
    return {path: made for path, made in spreads.items() if made is not None}


def _texts(messages: Sequence[RecordedSample]) -> dict[str, Counter[str]]:
    texts: dict[str, Counter[str]] = defaultdict(Counter)
    for message in messages:
        for path, value in message.fields.items():
            if isinstance(value, bool | str):
                texts[path][str(value)] += 1
    return dict(texts)


def is_infrastructure(topic: str) -> bool:
    """Whether a topic is of no node's own making: of ROS 2, of recorders, or of this tool's traces beside messages."""
    head = topic.strip("/").partition("/")[0]
    return head in ("rosout", "parameter_events", "clock", "events", "hricdv", "signals", "diagnostics", "log", "scene",
                    "bond", "robot_description") or "/_" in topic or topic in ("/tf", "/tf_static")  # fmt: skip
