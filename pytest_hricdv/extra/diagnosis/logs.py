"""Logs of the tests of a report: what monitors can be run on again, made of timelines.

Timelines are rounded: times to a millisecond, numbers to four digits, and of a signal with many changes only the least
and greatest values are kept. Bools, texts and messages are complete, so conditions over them are exact but for two
events in one millisecond.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pytest_hricdv._base import own_json as json
from pytest_hricdv.extra.diagnosis.records import Diagnosis
from pytest_hricdv.monitor import Log, Vocabulary
from pytest_hricdv.results.model import TestResult, Timeline

_KINDS: Mapping[str, type[bool] | type[float] | type[str]] = {"bool": bool, "float": float, "str": str}


@dataclass(frozen=True)
class LoggedMessage:
    """A message of a timeline."""

    time_s: float
    topic: str
    fields: Mapping[str, object]


def rounded(time_s: float) -> float:
    """A time (s) as timelines have it."""
    return round(time_s, 3)


def vocabulary_of(diagnosis: Diagnosis) -> Vocabulary:
    """The names that conditions may use."""
    messages = {
        topic: {name: _KINDS[kind] for name, kind in fields.items()} for topic, fields in diagnosis.messages.items()
    }
    return Vocabulary({name: _KINDS[kind] for name, kind in diagnosis.signals.items()}, messages)


def log_of(test: TestResult, vocabulary: Vocabulary) -> Log:
    """The log of a test that came to its end. Raises ValueError for one that did not."""
    timeline = test.timeline
    if timeline is None:
        raise ValueError(f"{test.id}: no run of it came to an end")
    signals = {name: _series(text) for name, text in timeline.signals.items() if name in vocabulary.signals}
    texts = {
        name: ([time_s for time_s, _ in changes], [text for _, text in changes])
        for name, changes in timeline.texts.items()
        if name in vocabulary.signals
    }
    return Log({**signals, **texts}, _messages(timeline, vocabulary), timeline.end_s)


def _series(text: str) -> tuple[list[float], list[float]]:
    numbers = [float(word) for word in text.split()]
    return numbers[::2], numbers[1::2]


def _messages(timeline: Timeline, vocabulary: Vocabulary) -> list[LoggedMessage]:
    made = []
    for message in timeline.messages:
        time_s, _, topic, fields = message.split("\t", 3)
        kinds = vocabulary.messages.get(topic)
        if kinds is not None:
            values = json.loads(fields)
            made.append(LoggedMessage(float(time_s), topic, {name: kind(values[name]) for name, kind in kinds.items()}))
    return made
