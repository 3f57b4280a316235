"""Adds recordings to the model of a draft: observed values, and differences between code and recordings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from pytest_hricdv.extra.draft.code_model import (
    CodeLine,
    CodeModel,
    FieldValue,
    Message,
    MessageField,
    Problem,
    Question,
)
from pytest_hricdv.extra.draft.observed import (
    MAX_TEXTS,
    MIN_OBSERVATIONS,
    Observation,
    ObservedTopic,
    is_infrastructure,
    key_of,
    observe,
)
from pytest_hricdv.extra.draft.ros.interfaces import interface_file
from pytest_hricdv.recordings.recording import read_recordings

MAX_LENGTH = 40
"""Longest text (characters) that counts as one of several choices, like the name of a state."""


def with_recordings(
    model: CodeModel, paths: Sequence[Path], packages: Mapping[str, Path]
) -> tuple[CodeModel, Observation | None]:
    """Add what recordings show to the model of the code.

    Args:
        model: the code.
        paths: the recordings.
        packages: name -> folder of the workspace's packages, whose interface files define types.

    Returns:
        The new model, and the observations; None if nothing could be read.
    """
    topics = {key for message in model.messages for key in _keys(message)}
    recordings = read_recordings(
        paths, lambda topic: _is_of(key_of(topic), topics), lambda kind: interface_file(kind, packages)
    )  # fmt: skip
    texts = [text for made in recordings for text in (*made.problems, *made.notes)]
    problems = [Problem("recording", text, None) for text in _shorten(texts)]
    if not any(made.parts for made in recordings):
        return replace(model, problems=(*model.problems, *problems)), None
    seen = _rename(observe(recordings), model.messages)
    messages = tuple(_with_values(message, seen) for message in model.messages)
    problems += [Problem("recording", text, location) for text, location in _differences(messages, seen)]
    questions = _open_questions(model.questions, seen)
    return (
        replace(
            model,
            messages=messages,
            problems=(*model.problems, *problems),
            questions=(*questions, *_questions(messages, seen)),
        ),
        seen,
    )


def _shorten(texts: Sequence[str], most: int = 10) -> list[str]:
    """At most `most` different sentences, and the number of the rest."""
    unique = list(dict.fromkeys(texts))
    return unique if len(unique) <= most else [*unique[:most], f"and {len(unique) - most} more such sentences"]


def _keys(message: Message) -> Iterator[str]:
    """Names that a recording may have for the topic of a message."""
    yield key_of(message.topic)
    if message.channel and message.form not in ("service", "action"):
        yield key_of(message.channel)
    yield key_of(message.name)


def _is_of(key: str, topics: set[str]) -> bool:
    return key in topics or any(key.endswith(f"_{topic}") for topic in topics if topic)


def _rename(seen: Observation, messages: Sequence[Message]) -> Observation:
    """Rename recorded topics as messages call them: `/robot1/scan` to `scan` if it is the only one."""
    topics = seen.topics
    renamed: dict[str, str] = {}
    for message in messages:
        own = key_of(message.topic)
        key = next((key for key in _keys(message) if key in topics), None)
        longer = [key for key in topics if any(key.endswith(f"_{name}") for name in _keys(message) if name)]
        chosen = key if key is not None else longer[0] if len(longer) == 1 else None
        if chosen is not None and chosen != own and own not in topics:
            renamed[chosen] = own
    return seen.rename(renamed)


def _with_values(message: Message, seen: Observation) -> Message:
    topic = seen.topics.get(key_of(message.topic))
    if topic is None:
        return message
    return replace(message, fields=tuple(_with_texts(part, topic, seen.source) for part in message.fields))


def _with_texts(part: MessageField, topic: ObservedTopic, source: str) -> MessageField:
    """A text field with the observed texts after those of the code, the most frequent first."""
    texts = topic.texts.get(part.name, Counter())
    if part.kind != "str" or part.by_type or not _are_choices(texts):
        return part
    there = {value.text for value in part.values}
    added = [FieldValue(text, CodeLine(f"observed {_times(count)} in {source}", 0), is_observed=True)
             for text, count in texts.most_common() if text.strip() and text not in there]  # fmt: skip
    return replace(part, values=(*part.values, *added))


def _are_choices(texts: Iterable[str]) -> bool:
    """Whether the texts are few and short: choices, and not free text."""
    return len(list(texts)) <= MAX_TEXTS and all(len(text) <= MAX_LENGTH for text in texts)


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"


def _differences(messages: Sequence[Message], seen: Observation) -> Iterator[tuple[str, CodeLine | None]]:
    """The parts that only the code has, and those that only the recordings have."""
    for message in messages:
        topic = seen.topics.get(key_of(message.topic))
        if topic is None:
            verb = {"received": "receives", "published": "publishes", "both": "publishes and receives"}[
                message.direction
            ]
            text = f"the code {verb} {message.name}: no message of it in {seen.source}, so nothing is observed of it"
            yield text, message.location
    topics_of_code = {key_of(message.topic) for message in messages}
    for key, topic in seen.topics.items():
        if key not in topics_of_code and not is_infrastructure(topic.name):
            count = "1 message" if topic.count == 1 else f"{topic.count} messages"
            yield f"{seen.source}: has {count} of {topic.name}, which the code neither publishes nor receives", None


def _open_questions(questions: Sequence[Question], seen: Observation) -> tuple[Question, ...]:
    """The questions without those for texts and numbers that were observed."""
    answered = {f"{key}.{path}" for key, topic in seen.topics.items() for path, texts in topic.texts.items()
                if _are_choices(texts)}  # fmt: skip
    answered |= {f"{key}.{path}" for key, topic in seen.topics.items() for path, numbers in topic.numbers.items()
                 if numbers.is_trusted}  # fmt: skip
    return tuple(question for question in questions if question.about not in answered)


def _questions(messages: Sequence[Message], seen: Observation) -> Iterator[Question]:
    for message in messages:
        topic = seen.topics.get(key_of(message.topic))
        if topic is None or message.direction == "published":
            continue
        if topic.count < MIN_OBSERVATIONS:
            count = "one message" if topic.count == 1 else f"{topic.count} messages"
            text = f"Is that all? {seen.source} has {count} of {topic.name}: too few to trust its ranges"
            yield Question(text, topic.name, message.location)
        for part in message.fields:
            texts = topic.texts.get(part.name, Counter())
            if part.kind == "str" and not _are_choices(texts):
                text = f"Which texts of `{message.topic}.{part.name}` matter? {seen.source} has {len(texts)} of them"
                yield Question(text, f"{message.topic}.{part.name}", part.location)
