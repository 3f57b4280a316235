"""The events and conditions of runs, by the names that requirements may use."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from pytest_hricdv.extra.suggestion.candidate import between, number
from pytest_hricdv.extra.suggestion.contents import content_events
from pytest_hricdv.extra.suggestion.stored_run import StoredMessage
from pytest_hricdv.extra.suggestion.views import Author, Condition, Event, Runs, edges, spans_where

LEAST_REST = 0.02
"""A number that is 0 for so much of the time has a rest, as a speed or a force has (chosen)."""

LEAST_AT_PLACE = 0.05
"""A change is one of a place where so many of it happen there (chosen)."""

LEAST_SPLIT = 0.15
"""A condition tells messages apart where it holds at so many of them, and does not at as many (chosen)."""


LEAST_GAP = 0.15
"""Values of a number are in two groups where nothing is in so much of their range (chosen)."""


def events_of(runs: Runs) -> list[Event]:
    """All events that happened at least once; of one author's that always coincide, the first."""
    made: dict[tuple[bool, str, tuple[tuple[float, ...], ...]], Event] = {}
    for event in (
        *_messages(runs),
        *_changes(runs),
        *_with_signals(runs),
        *_at_places(runs),
        *content_events(runs),
    ):
        if event.count:
            made.setdefault((event.is_state, event.author, event.times), event)
    return [*made.values()]


def _messages(runs: Runs) -> Iterator[Event]:
    for topic, fields in runs.vocabulary.messages.items():
        author = runs.author(topic)
        is_state = runs.state.partition(".")[0] == topic

        def where(
            text: str,
            words: str,
            matches: Callable[[StoredMessage], bool],
            *,
            narrow: bool = True,
            topic: str = topic,
            author: Author = author,
            is_state: bool = is_state,
        ) -> Event:
            times = tuple(
                tuple(dict.fromkeys(message.time_s for message in run if matches(message)))
                for run in runs.messages[topic]
            )
            return Event(text, topic, author, times, narrow, is_state, words)

        yield where(f"on({topic})", topic, lambda message: True, narrow=False)
        bools = [name for name, kind in fields.items() if kind is bool]
        if 2 <= len(bools) <= 5:
            every = " & ".join(f"{topic}.{name}" for name in bools)
            yield where(
                f"on({topic}) & {every}",
                f"{topic} with all true",
                lambda message, bools=tuple(bools): all(message.fields[name] for name in bools),  # type: ignore[misc]
            )
            yield where(
                f"on({topic}) & !({every})",
                f"{topic} with not all true",
                lambda message, bools=tuple(bools): not all(message.fields[name] for name in bools),  # type: ignore[misc]
            )
        for name in bools:
            for value in (True, False):
                yield where(
                    f"on({topic}) & {'' if value else '!'}{topic}.{name}",
                    f"{topic} with {'' if value else 'no '}{name}",
                    lambda message, name=name, value=value: bool(message.fields[name]) is value,  # type: ignore[misc]
                )
        for name in (name for name, kind in fields.items() if kind is str):
            for text in runs.values(f"{topic}.{name}"):
                yield where(
                    f'on({topic}) & {topic}.{name} == "{text}"',
                    f"{topic} {text}",
                    lambda message, name=name, text=text: message.fields[name] == text,  # type: ignore[misc]
                )


def _changes(runs: Runs) -> Iterator[Event]:
    # Numbers come last: what begins and ends with a bool is told by it.
    order = {bool: 0, str: 1, float: 2}
    conditions = sorted(
        signal_conditions(runs), key=lambda condition: order[runs.vocabulary.signals[condition.subject]]
    )
    for condition in conditions:
        if condition.text.startswith("!") or condition.text.endswith("== 0") or " < " in condition.text:
            continue
        author = runs.signal_author(condition.subject)
        both = [edges(spans, log) for spans, log in zip(condition.spans, runs.logs, strict=True)]
        risen, fallen = tuple(rises for rises, _ in both), tuple(falls for _, falls in both)
        yield Event(f"rise({condition.text})", condition.subject, author, risen, words=f"begin of {condition.words}")
        yield Event(f"fall({condition.text})", condition.subject, author, fallen, words=f"end of {condition.words}")


def _at_places(runs: Runs) -> Iterator[Event]:
    """Changes of bools while a text has one of its values, and not others: a thing let go here, and let go there."""
    conditions = signal_conditions(runs)
    texts = [condition for condition in conditions if runs.vocabulary.signals[condition.subject] is str]
    for changed in conditions:
        if runs.vocabulary.signals[changed.subject] is not bool or changed.text.startswith("!"):
            continue
        both = [edges(spans, log) for spans, log in zip(changed.spans, runs.logs, strict=True)]
        for word, name, place in (("rise", "begin", 0), ("fall", "end", 1)):
            every = [pair[place] for pair in both]
            total = sum(map(len, every))
            for condition in texts:
                times = tuple(
                    tuple(time_s for time_s in run if condition.holds(number, time_s))
                    for number, run in enumerate(every)
                )
                if LEAST_AT_PLACE <= sum(map(len, times)) / max(1, total) <= 1.0 - LEAST_AT_PLACE:
                    text = f"{word}({changed.text}) & {condition.text}"
                    words = f"{name} of {changed.words} with {condition.words}"
                    author = runs.signal_author(changed.subject)
                    yield Event(text, changed.subject, author, times, narrow=True, words=words)


def _with_signals(runs: Runs) -> Iterator[Event]:
    """Messages while a bool holds, or a number is large, and while not: with and without a cup, an order asks for two
    things, and a robot that gives up has two reasons.

    First those of people, which tell apart what the robot is to do.
    """
    signals = runs.vocabulary.signals.items()
    # What the code under test sets may be its reaction already, at the same instant.
    moved = [name for name, kind in signals if kind is not str and runs.signal_author(name) != "robot"]
    conditions = [
        condition
        for condition in signal_conditions(runs)
        if condition.subject in moved and not condition.text.endswith(("== 0", "> 0"))
    ]
    topics = [topic for topic in runs.vocabulary.messages if topic != runs.state.partition(".")[0]]
    for topic in sorted(topics, key=lambda topic: runs.author(topic) != "person"):
        author = runs.author(topic)
        every = tuple(tuple(dict.fromkeys(message.time_s for message in run)) for run in runs.messages[topic])
        total = sum(map(len, every))
        for condition in conditions:
            times = tuple(
                tuple(time_s for time_s in run if condition.holds(place, time_s)) for place, run in enumerate(every)
            )
            if LEAST_SPLIT <= sum(map(len, times)) / max(1, total) <= 1.0 - LEAST_SPLIT:
                text, words = f"on({topic}) & {condition.text}", f"{topic} with {condition.words}"
                yield Event(text, topic, author, times, narrow=True, words=words)


def signal_conditions(runs: Runs) -> list[Condition]:
    """What holds of signals for a while: bools, texts, and numbers that rest at 0."""
    return [*_of_signals(runs)]


def _of_signals(runs: Runs) -> Iterator[Condition]:
    for name, kind in runs.vocabulary.signals.items():
        series = runs.series(name)
        if not any(len(times) for times, _ in series):
            continue

        def where(
            text: str,
            words: str,
            matches: Callable[[object], bool],
            *,
            name: str = name,
            series: Sequence[tuple[Sequence[float], Sequence[object]]] = series,
        ) -> Condition:
            spans = tuple(
                spans_where(log, times, [matches(value) for value in values])
                for log, (times, values) in zip(runs.logs, series, strict=True)
            )
            return Condition(text, name, spans, runs.share(spans), words)

        if kind is bool:
            yield where(name, name, bool)
            yield where(f"!{name}", f"no {name}", lambda value: not value)
        elif kind is str:
            for text in runs.values(name):
                yield where(f'{name} == "{text}"', f"{name} {text}", lambda value, text=text: value == text)  # type: ignore[misc]
        else:
            rest = where(f"{name} == 0", f"{name} 0", lambda value: value == 0.0)
            if LEAST_REST <= rest.share < 1.0:
                yield rest
                yield where(f"{name} > 0", f"{name} above 0", lambda value: float(value) > 0.0)  # type: ignore[arg-type]
            split = _middle_of_gap([float(value) for _, values in series for value in values])
            if split is not None:
                text = number(split)
                yield where(f"{name} >= {text}", f"{name} at least {text}", lambda value, s=split: float(value) >= s)  # type: ignore[misc]
                yield where(f"{name} < {text}", f"{name} below {text}", lambda value, s=split: float(value) < s)  # type: ignore[misc]


def _middle_of_gap(values: Sequence[float]) -> float | None:
    """The number between two groups of values, where all of them are in two groups; None where they are not."""
    ordered = sorted(values)
    if not ordered or ordered[0] == ordered[-1]:
        return None
    whole = ordered[-1] - ordered[0]
    place = max(range(1, len(ordered)), key=lambda place: ordered[place] - ordered[place - 1])
    low, high = ordered[place - 1], ordered[place]
    is_part = LEAST_SPLIT <= place / len(ordered) <= 1.0 - LEAST_SPLIT
    is_varied = low > ordered[0] and high < ordered[-1]  # a number with two values is a state, or a bool
    return between(low, high) if is_part and is_varied and high - low >= LEAST_GAP * whole else None


def state_conditions(runs: Runs) -> list[Condition]:
    """In which state the code under test says to be; none where it does not say so."""
    if not runs.state:
        return []
    topic, _, name = runs.state.partition(".")
    made = []
    for text in runs.values(runs.state):
        spans = tuple(
            spans_where(
                log, [message.time_s for message in messages], [message.fields[name] == text for message in messages]
            )
            for log, messages in zip(runs.logs, runs.messages[topic], strict=True)
        )
        words = f"state {text}"
        made.append(Condition(f'{runs.state} == "{text}"', topic, spans, runs.share(spans), words, is_state=True))
    return made


def scope(runs: Runs, begin: Event, end: Event) -> Condition:
    """The time from each begin to the next end, as a condition."""
    spans = []
    for log, begins, ends in zip(runs.logs, begin.times, end.times, strict=True):
        changes = sorted({*begins, *ends})
        spans.append(spans_where(log, changes, [time_s not in {*ends} for time_s in changes]))
    text = (
        f"!({end.text}) since {_operand(begin.text)}"
        if "&" in end.text
        else f"!{end.text} since {_operand(begin.text)}"
    )
    words = f"between {begin.words} and {end.words}"
    return Condition(text, f"{begin.subject} {end.subject}", tuple(spans), runs.share(spans), words)


def _operand(text: str) -> str:
    return f"({text})" if "&" in text else text
