"""What a recording adds to a draft: values that were observed, and what code and recording do not share."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from pytest_hricdv.extra.draft.code_model import (
    CodeModel,
    FieldValue,
    Location,
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
from pytest_hricdv.extra.draft.recording import read_recordings
from pytest_hricdv.extra.draft.ros.interfaces import interface_file

MAX_LENGTH = 40
"""Characters of a text that is one of several choices, as the name of a state is."""


def with_recordings(
    model: CodeModel, paths: Sequence[Path], packages: Mapping[str, Path]
) -> tuple[CodeModel, Observation | None]:
    """CodeModel with what recordings show; and that, None where nothing could be read.

    Args:
        model: of the code.
        paths: of recordings.
        packages: of the workspace, by name: their interface files define types.
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
    """Sentences on recordings; of many files, the first ones, and how many more there are."""
    unique = list(dict.fromkeys(texts))
    return unique if len(unique) <= most else [*unique[:most], f"and {len(unique) - most} more such sentences"]


def _keys(message: Message) -> Iterator[str]:
    """How a recording may call the topic of a message."""
    yield key_of(message.topic)
    if message.channel and message.form not in ("service", "action"):
        yield key_of(message.channel)
    yield key_of(message.name)


def _is_of(key: str, topics: set[str]) -> bool:
    return key in topics or any(key.endswith(f"_{topic}") for topic in topics if topic)


def _rename(seen: Observation, messages: Sequence[Message]) -> Observation:
    """The same with the topics of messages as these call them: `/robot1/scan` is the only `scan`."""
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
    """A field of texts with those that were observed, the most frequent first, after those of the code."""
    texts = topic.texts.get(part.name, Counter())
    if part.kind != "str" or part.by_type or not _are_choices(texts):
        return part
    there = {value.text for value in part.values}
    added = [FieldValue(text, Location(f"observed {_times(count)} in {source}", 0), is_observed=True)
             for text, count in texts.most_common() if text.strip() and text not in there]  # fmt: skip
    return replace(part, values=(*part.values, *added))


def _are_choices(texts: Iterable[str]) -> bool:
    """Whether texts are few and short, so that one is chosen, and not written."""
    return len(list(texts)) <= MAX_TEXTS and all(len(text) <= MAX_LENGTH for text in texts)


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"


def _differences(messages: Sequence[Message], seen: Observation) -> Iterator[tuple[str, Location | None]]:
    """What only the code has, and what only the recordings have."""
    for message in messages:
        topic = seen.topics.get(key_of(message.topic))
        if topic is None:
            verb = {"received": "receives", "published": "publishes", "both": "publishes and receives"}[
                message.direction
            ]
            text = f"the code {verb} {message.name}: no message of it in {seen.source}, so nothing is observed of it"
            yield text, message.location
            continue
        yield from _field_differences(message, topic, seen.source)
    known = {key_of(message.topic) for message in messages}
    for key, topic in seen.topics.items():
        if key not in known and not is_infrastructure(topic.name):
            count = "1 message" if topic.count == 1 else f"{topic.count} messages"
            yield f"{seen.source}: has {count} of {topic.name}, which the code neither publishes nor receives", None


def _field_differences(message: Message, topic: ObservedTopic, source: str) -> Iterator[tuple[str, Location | None]]:
    for part in message.fields if topic.numbers or topic.texts else ():
        name, texts = f"{message.name}.{part.name}", topic.texts.get(part.name, Counter())
        if part.kind and part.name not in topic.numbers and not texts:
            yield f"{name} is in the code, but in no message of {source}", part.location
        lacking = [repr(value.text) for value in part.values if value.text not in texts and not value.is_observed]
        if part.kind == "str" and texts and lacking:
            yield f"{name}: never observed in {source}: {', '.join(lacking)}", part.location
        new = [repr(text) for text in texts if part.by_type and text not in {value.text for value in part.values}]
        if part.kind == "str" and new:
            yield f"{name}: {source} has {', '.join(new)}, which its type has not", part.location


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
