"""What happened in runs, as requirements speak of it: events with their times, and conditions with when they held."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Literal

from pytest_hricdv.extra.suggestion.stored_run import StoredMessage, StoredRun
from pytest_hricdv.monitor import Log, Vocabulary

Author = Literal["robot", "person", "world"]
"""Who causes an event: the code under test, an actor of the model, or nobody of whom that is known."""

MOST_VALUES = 16
"""A text with more values than that is a remark, and no state (chosen: the table's controller has 12 states)."""


@dataclass(frozen=True)
class Event:
    """Something that happens at single instants.

    Args:
        text: as a formula has it.
        subject: the topic or signal.
        author: who causes it.
        times: per run, when it happened (s), ascending.
        narrow: it is a part of what happens to its subject, such as messages with one value of a field.
        is_state: the code under test tells its own state by it.
        words: for people.
    """

    text: str
    subject: str
    author: Author
    times: tuple[tuple[float, ...], ...]
    narrow: bool = False
    is_state: bool = False
    words: str = ""

    @property
    def is_message(self) -> bool:
        """Whether it is that a message comes, or a message that says something else than before."""
        return self.text.startswith(("on(", f"rise({self.subject}.", f"rise(!{self.subject}."))

    @cached_property
    def count(self) -> int:
        """How often it happened in all runs."""
        return sum(map(len, self.times))


@dataclass(frozen=True)
class Condition:
    """Something that holds for a while.

    Args:
        text: as a formula has it.
        subject: the signal, or topic.
        spans: per run, from when to when it held (s), ascending.
        share: of the time of all runs.
        words: for people.
        is_state: see `Event`.
    """

    text: str
    subject: str
    spans: tuple[tuple[tuple[float, float], ...], ...]
    share: float
    words: str = ""
    is_state: bool = False

    def holds(self, run: int, time_s: float, *, before: bool = False) -> bool:
        """Whether it holds at a time, or just before it."""
        spans = self.spans[run]
        place = bisect_right(spans, (time_s, float("inf"))) - 1
        if before and place >= 0 and spans[place][0] == time_s:
            place -= 1
        return place >= 0 and (time_s <= spans[place][1] if before else time_s < spans[place][1])


@dataclass(frozen=True)
class Runs:
    """Runs that suggestions are learnt of.

    Args:
        runs: as they are stored.
        vocabulary: of requirements.
        actors: the names of those who act in the model.
        state: the field by which the code under test tells its state, as `topic.field`; empty for none.
        unmoved: signals that the code under test has little to do with.
        logs: of the runs.
    """

    runs: Sequence[StoredRun]
    vocabulary: Vocabulary
    actors: frozenset[str] = frozenset()
    state: str = ""
    unmoved: frozenset[str] = frozenset()
    logs: tuple[Log, ...] = field(default=(), repr=False)

    @classmethod
    def of(
        cls,
        runs: Sequence[StoredRun],
        vocabulary: Vocabulary,
        actors: Iterable[str] = (),
        state: str = "",
        unmoved: Iterable[str] = (),
    ) -> Runs:
        """With the logs of the runs, read once."""
        logs = tuple(run.log() for run in runs)
        return cls(runs, vocabulary, frozenset(actors), state, frozenset(unmoved), logs)

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
        """Who sends a topic."""
        if any(topic in run.own_topics for run in self.runs):
            return "robot"
        senders = {message.sender for run in self.messages[topic] for message in run}
        return "person" if senders and senders <= self.actors else "world"

    def signal_author(self, name: str) -> Author:
        """Who changes a signal: the code under test in calls of its own, a person likewise, or the world."""
        if name in self.unmoved:
            return "person"
        changed = [
            run for run, log in zip(self.runs, self.logs, strict=True) if len(log.signals.get(name, ((),))[0]) > 1
        ]
        if changed and all(name in run.own_signals for run in changed):
            return "robot"
        return "person" if changed and all(name in run.other_signals for run in changed) else "world"

    def series(self, name: str) -> list[tuple[Sequence[float], Sequence[float] | Sequence[str]]]:
        """Per run, when a signal changed (s) and to what; of several changes at an instant the last."""
        return [_settled(*log.signals.get(name, ((), ()))) for log in self.logs]

    def values(self, name: str) -> list[str]:
        """The values that a text had in the runs, sorted; none where these are too many."""
        topic, dot, member = name.partition(".")
        if dot:
            seen = {str(message.fields[member]) for run in self.messages[topic] for message in run}
        else:
            seen = {str(value) for _, values in self.series(name) for value in values}
        return sorted(seen) if len(seen) <= MOST_VALUES else []

    def value_at(self, name: str, run: int, time_s: float) -> float | str | None:
        """The value of a signal at a time (s); None before its first."""
        times, values = self._series_of[name][run]
        place = bisect_right(times, time_s)
        return values[place - 1] if place else None

    @cached_property
    def _series_of(self) -> Mapping[str, list[tuple[Sequence[float], Sequence[float] | Sequence[str]]]]:
        return {name: self.series(name) for name in self.vocabulary.signals}

    def share(self, spans: Iterable[Iterable[tuple[float, float]]]) -> float:
        """The part of the time of all runs that these spans take."""
        return sum(end_s - begin_s for run in spans for begin_s, end_s in run) / self.total_s


def copied(runs: Sequence[StoredRun], vocabulary: Vocabulary) -> frozenset[str]:
    """The signals that repeat what messages say: they change with a message only, and then to what a field of it says.

    What is asked of such a signal is asked of the message, and that both say the same is nothing to ask for.
    """
    logs = [run.log() for run in runs]
    return frozenset(
        name
        for name in vocabulary.signals
        if any(
            _repeats(name, topic, member, runs, logs)
            for topic, fields in vocabulary.messages.items()
            for member in fields
        )
    )


def _repeats(name: str, topic: str, member: str, runs: Sequence[StoredRun], logs: Sequence[Log]) -> bool:
    changes = 0
    for run, log in zip(runs, logs, strict=True):
        said: dict[float, list[object]] = {}
        for message in run.messages:
            if message.topic == topic:
                said.setdefault(message.time_s, []).append(message.fields.get(member))
        times, values = log.signals.get(name, ((), ()))
        for time_s, value in [*zip(times, values, strict=True)][1:]:  # its first value is no change
            changes += 1
            if value not in said.get(time_s, ()):
                return False
    return changes > 0


def _settled(
    times: Sequence[float], values: Sequence[float] | Sequence[str]
) -> tuple[Sequence[float], Sequence[float] | Sequence[str]]:
    kept = [place for place in range(len(times)) if place + 1 == len(times) or times[place + 1] > times[place]]
    if len(kept) == len(times):
        return times, values
    return [times[place] for place in kept], [values[place] for place in kept]  # type: ignore[return-value]


def next_at(times: Sequence[float], time_s: float) -> float | None:
    """The first of these times that is not before a time."""
    place = bisect_left(times, time_s)
    return times[place] if place < len(times) else None


def next_after(times: Sequence[float], time_s: float) -> float | None:
    """The first of these times after a time."""
    place = bisect_right(times, time_s)
    return times[place] if place < len(times) else None


def last_before(times: Sequence[float], time_s: float) -> float | None:
    """The last of these times before a time."""
    place = bisect_left(times, time_s)
    return times[place - 1] if place else None


def spans_where(log: Log, times: Sequence[float], truths: Sequence[bool]) -> tuple[tuple[float, float], ...]:
    """From when to when (s) something held that changed at these times."""
    spans: list[tuple[float, float]] = []
    ends = [*times[1:], log.end_s][: len(times)]
    for begin_s, end_s, holds in zip(times, ends, truths, strict=True):
        if holds and spans and spans[-1][1] == begin_s:
            spans[-1] = (spans[-1][0], end_s)
        elif holds:
            spans.append((begin_s, end_s))
    return tuple(spans)


def edges(spans: Sequence[tuple[float, float]], log: Log) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """When a condition became true and false (s); what is true from the start did not become so."""
    start_s = log.start_s
    rises = tuple(begin_s for begin_s, _ in spans if begin_s > start_s)
    return rises, tuple(end_s for _, end_s in spans if end_s < log.end_s)


def gaps(times: Sequence[float]) -> list[float]:
    """The times (s) between neighbours."""
    return [later - earlier for earlier, later in pairwise(times)]
