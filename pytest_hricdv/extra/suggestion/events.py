"""What stored runs show, as formulas name it: events at instants, and conditions that hold for a while.

`find_events` and `signal_conditions` find them in `Runs`, the runs to mine; the templates make candidates of them.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Literal

from pytest_hricdv.extra.suggestion.candidate import MIN_SUPPORT
from pytest_hricdv.extra.suggestion.stored_run import StoredMessage, StoredRun
from pytest_hricdv.monitor import Log, Vocabulary
from pytest_hricdv.runtime.record import Value

Author = Literal["robot", "person", "world"]
"""The cause of an event: the code under test, an actor of the model, or neither as far as is known."""

Series = tuple[Sequence[float], Sequence[float] | Sequence[str]]
"""Times (s) and values."""

Spans = tuple[tuple[tuple[float, float], ...], ...]
"""Per run, from when to when (s) something held, ascending."""

MAX_VALUES = 16
"""A text field with more different values is not a state: the case study's controller has 12 states."""

MAX_EVENTS = 60
"""Maximum number of events, which are combined in pairs: complete topics first, then the most frequent events."""

MAX_A_RUN = 200
"""Messages that occur more often per run, on average, are samples of a value and not events."""


@dataclass(frozen=True)
class RecordedEvent:
    """Something that happens at single instants.

    Args:
        text: as a formula has it.
        subject: the topic or signal.
        author: who causes it.
        times: per run, when it happened (s), ascending.
        is_part: whether it is a part of what happens to its subject, such as messages with one value of a field.
        is_state: whether the code under test reports its own state by it.
        words: for people.
    """

    text: str
    subject: str
    author: Author
    times: tuple[tuple[float, ...], ...]
    is_part: bool = False
    is_state: bool = False
    words: str = ""

    @property
    def is_message(self) -> bool:
        """Whether a message comes."""
        return self.text.startswith("on(")

    @property
    def operand(self) -> str:
        """Its text as an operand of a formula."""
        return f"({self.text})" if "&" in self.text else self.text

    @cached_property
    def count(self) -> int:
        """Its number of occurrences in all runs."""
        return sum(map(len, self.times))


@dataclass(frozen=True)
class SignalCondition:
    """A condition on a signal, with the spans in which it held.

    Args:
        text: as a formula has it.
        subject: the signal.
        spans: when it held.
        share: the share of the time of all runs.
        words: for people.
    """

    text: str
    subject: str
    spans: Spans
    share: float
    words: str

    def holds(self, run: int, time_s: float) -> bool:
        """Whether it holds at a time."""
        spans = self.spans[run]
        place = bisect_right(spans, (time_s, float("inf"))) - 1
        return place >= 0 and time_s < spans[place][1]


@dataclass(frozen=True)
class Runs:
    """The runs that suggestions are mined from.

    Args:
        runs: as they are stored.
        vocabulary: the vocabulary of requirements.
        actors: the names of those who act in the model.
        state: the field by which the code under test reports its state, as `topic.field`; empty for none.
    """

    runs: Sequence[StoredRun]
    vocabulary: Vocabulary
    actors: frozenset[str] = frozenset()
    state: str = ""
    logs: tuple[Log, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "logs", tuple(run.log() for run in self.runs))

    @cached_property
    def total_s(self) -> float:
        """Simulated time of all runs (s)."""
        return sum(log.end_s for log in self.logs) or 1.0

    @cached_property
    def messages(self) -> Mapping[str, tuple[tuple[StoredMessage, ...], ...]]:
        """Topic -> per run, its messages."""
        return {
            topic: tuple(tuple(message for message in run.messages if message.topic == topic) for run in self.runs)
            for topic in self.vocabulary.messages
        }

    @cached_property
    def acts(self) -> tuple[tuple[float, ...], ...]:
        """Per run, when a person sent something (s)."""
        topics = [topic for topic in self.messages if self.author(topic) == "person"]
        return tuple(tuple(message.time_s for message in run.messages if message.topic in topics) for run in self.runs)

    def author(self, topic: str) -> Author:
        """The sender of a topic."""
        if any(topic in run.own_topics for run in self.runs):
            return "robot"
        senders = {message.sender for run in self.messages[topic] for message in run}
        return "person" if senders and senders <= self.actors else "world"

    def signal_author(self, name: str) -> Author:
        """The author of a signal's changes."""
        changed = [
            run for run, log in zip(self.runs, self.logs, strict=True) if len(log.signals.get(name, ((),))[0]) > 1
        ]
        if changed and all(name in run.own_signals for run in changed):
            return "robot"
        return "person" if changed and all(name in run.other_signals for run in changed) else "world"

    def series(self, name: str) -> list[Series]:
        """Per run, when a signal changed (s) and to what; of several changes at an instant the last."""
        return [_last_of_instants(*log.signals.get(name, ((), ()))) for log in self.logs]

    def values(self, name: str) -> list[str]:
        """The values that a string had in the runs, sorted; none if there are too many."""
        topic, dot, member = name.partition(".")
        if dot:
            seen = {str(message.fields[member]) for run in self.messages[topic] for message in run}
        else:
            seen = {str(value) for _, values in self.series(name) for value in values}
        return sorted(seen) if len(seen) <= MAX_VALUES else []

    def share(self, spans: Iterable[Iterable[tuple[float, float]]]) -> float:
        """The part of the time of all runs that these spans take."""
        return sum(end_s - begin_s for run in spans for begin_s, end_s in run) / self.total_s


def find_events(runs: Runs) -> list[RecordedEvent]:
    """The events of all runs; of one author's events that always coincide, the first."""
    distinct: dict[tuple[bool, str, tuple[tuple[float, ...], ...]], RecordedEvent] = {}
    for event in (*_messages(runs), *_edges_of_signals(runs), *_messages_by_signal(runs)):
        if 0 < event.count <= MAX_A_RUN * len(runs.runs):
            distinct.setdefault((event.is_state, event.author, event.times), event)
    order = sorted(distinct.values(), key=lambda event: (event.is_state, event.is_part, -event.count, event.text))
    return order[:MAX_EVENTS]


def _messages(runs: Runs) -> Iterator[RecordedEvent]:
    """All messages of a topic, and those with a value of a bool or text."""
    for topic, fields in runs.vocabulary.messages.items():
        parts: list[tuple[str, str, str, Value]] = []
        for name, kind in fields.items():
            if kind is bool:
                parts += [(f"{topic}.{name}", f"{topic} with {name}", name, True)]
                parts += [(f"!{topic}.{name}", f"{topic} with no {name}", name, False)]
            elif kind is str:
                values = runs.values(f"{topic}.{name}")
                parts += [(f'{topic}.{name} == "{text}"', f"{topic} {text}", name, text) for text in values]
        author, is_state = runs.author(topic), runs.state.partition(".")[0] == topic
        yield RecordedEvent(f"on({topic})", topic, author, _times(runs, topic, lambda _: True), False, is_state, topic)
        for text, words, name, value in parts:
            times = _times(runs, topic, partial(_has, name, value))
            yield RecordedEvent(f"on({topic}) & {text}", topic, author, times, True, is_state, words)


def _has(name: str, value: Value, message: StoredMessage) -> bool:
    return message.fields[name] == value


def _times(runs: Runs, topic: str, matches: Callable[[StoredMessage], bool]) -> tuple[tuple[float, ...], ...]:
    return tuple(
        tuple(dict.fromkeys(message.time_s for message in run if matches(message))) for run in runs.messages[topic]
    )


def _edges_of_signals(runs: Runs) -> Iterator[RecordedEvent]:
    """When conditions on signals begin and end to hold; bools first, numbers last."""
    order = {bool: 0, str: 1, float: 2}
    kinds = runs.vocabulary.signals
    for condition in sorted(signal_conditions(runs), key=lambda condition: order[kinds[condition.subject]]):
        if condition.text.startswith("!") or condition.text.endswith("== 0"):
            continue
        author = runs.signal_author(condition.subject)
        spans = [*zip(condition.spans, runs.logs, strict=True)]
        rises = tuple(tuple(begin_s for begin_s, _ in run if begin_s > log.start_s) for run, log in spans)
        falls = tuple(tuple(end_s for _, end_s in run if end_s < log.end_s) for run, log in spans)
        for operator, verb, times in (("rise", "begin", rises), ("fall", "end", falls)):
            text, words = f"{operator}({condition.text})", f"{verb} of {condition.words}"
            yield RecordedEvent(text, condition.subject, author, times, words=words)


def _messages_by_signal(runs: Runs) -> Iterator[RecordedEvent]:
    """Messages while a bool of the world or of people holds, and while not: an order with and without a cup.

    Signals of the code under test may be its reaction already, at the same instant.
    """
    conditions = [
        condition
        for condition in signal_conditions(runs)
        if runs.vocabulary.signals[condition.subject] is bool and runs.signal_author(condition.subject) != "robot"
    ]
    for topic in runs.vocabulary.messages:
        if topic == runs.state.partition(".")[0]:
            continue
        instants = _times(runs, topic, lambda _: True)
        total = sum(map(len, instants))
        for condition in conditions:
            times = tuple(
                tuple(time_s for time_s in run if condition.holds(place, time_s)) for place, run in enumerate(instants)
            )
            if MIN_SUPPORT <= sum(map(len, times)) <= total - MIN_SUPPORT:
                text, words = f"on({topic}) & {condition.text}", f"{topic} with {condition.words}"
                yield RecordedEvent(text, topic, runs.author(topic), times, is_part=True, words=words)


def signal_conditions(runs: Runs) -> list[SignalCondition]:
    """What holds of signals for a while: bools, texts, and numbers that rest at 0."""
    return [*_conditions(runs)]


def _conditions(runs: Runs) -> Iterator[SignalCondition]:
    for name, kind in runs.vocabulary.signals.items():
        series = runs.series(name)
        if not any(len(times) for times, _ in series):
            continue
        if kind is bool:
            yield _condition(runs, name, series, name, name, bool)
            yield _condition(runs, name, series, f"!{name}", f"no {name}", lambda value: not value)
        elif kind is str:
            for text in runs.values(name):
                formula, words = f'{name} == "{text}"', f"{name} {text}"
                yield _condition(runs, name, series, formula, words, lambda value, text=text: value == text)  # type: ignore[misc]
        else:
            rest = _condition(runs, name, series, f"{name} == 0", f"{name} 0", lambda value: value == 0.0)
            if 0.0 < rest.share < 1.0:
                yield rest
                yield _condition(
                    runs, name, series, f"{name} > 0", f"{name} above 0", lambda value: float(str(value)) > 0.0
                )


def _condition(
    runs: Runs, name: str, series: Sequence[Series], text: str, words: str, matches: Callable[[object], bool]
) -> SignalCondition:
    spans = tuple(
        _spans(log, times, [matches(value) for value in values])
        for log, (times, values) in zip(runs.logs, series, strict=True)
    )
    return SignalCondition(text, name, spans, runs.share(spans), words)


def _last_of_instants(times: Sequence[float], values: Sequence[float] | Sequence[str]) -> Series:
    kept = [place for place in range(len(times)) if place + 1 == len(times) or times[place + 1] > times[place]]
    if len(kept) == len(times):
        return times, values
    return [times[place] for place in kept], [values[place] for place in kept]  # type: ignore[return-value]


def _spans(log: Log, times: Sequence[float], truths: Sequence[bool]) -> tuple[tuple[float, float], ...]:
    """The spans (s) during which a condition held that changed at these times."""
    spans: list[tuple[float, float]] = []
    ends = [*times[1:], log.end_s][: len(times)]
    for begin_s, end_s, holds in zip(times, ends, truths, strict=True):
        if holds and spans and spans[-1][1] == begin_s:
            spans[-1] = (spans[-1][0], end_s)
        elif holds:
            spans.append((begin_s, end_s))
    return tuple(spans)


def next_after(times: Sequence[float], time_s: float) -> float | None:
    """The first of these times after a time."""
    place = bisect_right(times, time_s)
    return times[place] if place < len(times) else None


def last_before(times: Sequence[float], time_s: float) -> float | None:
    """The last of these times before a time."""
    place = bisect_left(times, time_s)
    return times[place - 1] if place else None
