"""Adds bags of the real system (`--recording`) to the model of the code: values, and differences from the code."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from pytest_hricdv.extra.draft.code_model import CodeLine, CodeModel, Message, MessageField, Problem, Question
from pytest_hricdv.extra.draft.observe.shape import Shape
from pytest_hricdv.extra.draft.observed_calls import texts_of_shape
from pytest_hricdv.extra.draft.ros.interfaces import interface_file
from pytest_hricdv.recordings.recording import Recording, read_recordings

MIN_OBSERVATIONS = 10
"""Least observations for a range; with fewer, it is a question. The next value lies outside the extremes of n
observations with a chance of 2 / (n + 1), whatever their distribution: 18 % with 10."""


@dataclass
class TopicShapes:
    """A topic in bags.

    Args:
        name: as it was recorded.
        count: number of its messages.
        fields: path of a field -> its values, those of all elements of an array.
    """

    name: str
    count: int = 0
    fields: dict[str, Shape] = field(default_factory=dict)


def key_of(topic: str) -> str:
    """A topic as drafts and requirements call it.

    >>> key_of("/arm/moving")
    'arm_moving'
    """
    return re.sub(r"[^a-z0-9]+", "_", topic.lower()).strip("_")


def with_recordings(model: CodeModel, paths: Sequence[Path], packages: Mapping[str, Path]) -> CodeModel:
    """Add what bags show to the model of the code.

    Args:
        model: the code.
        paths: the bags.
        packages: name -> folder of the workspace's packages, whose interface files define types.
    """
    topics = {key for message in model.messages for key in _keys(message)}
    recordings = read_recordings(
        paths, lambda topic: _is_of(key_of(topic), topics), lambda kind: interface_file(kind, packages)
    )  # fmt: skip
    texts = [text for made in recordings for text in (*made.problems, *made.notes)]
    problems = [Problem("recording", text, None) for text in _shorten(texts)]
    if not any(made.parts for made in recordings):
        return replace(model, problems=(*model.problems, *problems))
    names = list(dict.fromkeys(recording.name for recording in recordings if recording.parts))
    source = ", ".join(names) if len(names) <= 2 else f"{len(names)} recordings"
    seen = _rename(_observe(recordings), model.messages)
    messages = tuple(_with_values(message, seen, source) for message in model.messages)
    problems += [Problem("recording", text, location) for text, location in _differences(messages, seen, source)]
    questions = (*_open_questions(model.questions, seen), *_questions(messages, seen, source))
    return replace(model, messages=messages, problems=(*model.problems, *problems), questions=questions)


def _observe(recordings: Sequence[Recording]) -> dict[str, TopicShapes]:
    topics: dict[str, TopicShapes] = {}
    for message in (message for recording in recordings for part in recording.parts for message in part):
        topic = topics.setdefault(key_of(message.topic), TopicShapes(message.topic))
        topic.count += 1
        for path, value in message.fields.items():
            for part in value if isinstance(value, tuple) else (value,):
                topic.fields.setdefault(path, Shape()).add(part, path)
    return topics


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


def _rename(topics: Mapping[str, TopicShapes], messages: Sequence[Message]) -> dict[str, TopicShapes]:
    """Rename recorded topics as messages call them: `/robot1/scan` to `scan` if it is the only one."""
    renamed: dict[str, str] = {}
    for message in messages:
        own = key_of(message.topic)
        key = next((key for key in _keys(message) if key in topics), None)
        longer = [key for key in topics if any(key.endswith(f"_{name}") for name in _keys(message) if name)]
        chosen = key if key is not None else longer[0] if len(longer) == 1 else None
        if chosen is not None and chosen != own and own not in topics:
            renamed[chosen] = own
    return {renamed.get(key, key): topic for key, topic in topics.items()}


def _with_values(message: Message, seen: Mapping[str, TopicShapes], source: str) -> Message:
    topic = seen.get(key_of(message.topic))
    if topic is None:
        return message
    place = CodeLine(f"{'' if topic.count >= MIN_OBSERVATIONS else 'TODO: '}observed in {_count(topic)} of {source}", 0)
    return replace(message, fields=tuple(_with_observed(part, topic.fields.get(part.name), place)
                                         for part in message.fields))  # fmt: skip


def _with_observed(part: MessageField, shape: Shape | None, place: CodeLine) -> MessageField:
    """A number that the code compares with nothing, with its range; a text, with those after the ones of the code."""
    if shape is None:
        return part
    if part.kind == "float" and shape.low is not None and shape.high is not None and not part.compared:
        return replace(part, observed=(shape.low, shape.high), location=place)
    if part.kind == "str" and not part.by_type:
        there = {value.text for value in part.values}
        added = tuple(value for value in texts_of_shape(shape, place) if value.text not in there)
        return replace(part, values=(*part.values, *added))
    return part


def _count(topic: TopicShapes) -> str:
    return "1 message" if topic.count == 1 else f"{topic.count} messages"


def _differences(
    messages: Sequence[Message], seen: Mapping[str, TopicShapes], source: str
) -> Iterator[tuple[str, CodeLine | None]]:
    """The topics that only the code has, and those that only the bags have."""
    verbs = {"received": "receives", "published": "publishes", "both": "publishes and receives"}
    for message in messages:
        if key_of(message.topic) not in seen:
            text = f"the code {verbs[message.direction]} {message.name}: no message of it in {source}"
            yield f"{text}, so nothing is observed of it", message.location
    topics_of_code = {key_of(message.topic) for message in messages}
    for key, topic in seen.items():
        if key not in topics_of_code and not is_infrastructure(topic.name):
            yield f"{source}: has {_count(topic)} of {topic.name}, which the code neither publishes nor receives", None


def _open_questions(questions: Sequence[Question], seen: Mapping[str, TopicShapes]) -> tuple[Question, ...]:
    """The questions without those for strings and numbers that were observed."""
    answered = {f"{key}.{path}" for key, topic in seen.items() for path, shape in topic.fields.items()
                if not shape.is_open and topic.count >= MIN_OBSERVATIONS}  # fmt: skip
    return tuple(question for question in questions if question.about not in answered)


def _questions(messages: Sequence[Message], seen: Mapping[str, TopicShapes], source: str) -> Iterator[Question]:
    for message in messages:
        topic = seen.get(key_of(message.topic))
        if topic is None or message.direction == "published":
            continue
        if topic.count < MIN_OBSERVATIONS:
            text = f"Is that all? {source} has {_count(topic)} of {topic.name}: too few to trust its ranges"
            yield Question(text, topic.name, message.location)
        for part in message.fields:
            shape = topic.fields.get(part.name)
            if part.kind == "str" and shape is not None and shape.is_open:
                text = f"Which strings of `{message.topic}.{part.name}` matter? {source} has too many, or too long ones"
                yield Question(text, f"{message.topic}.{part.name}", part.location)


def is_infrastructure(topic: str) -> bool:
    """Whether a topic is of no node's own making: of ROS 2, of recorders, or of this tool's traces next to messages."""
    head = topic.strip("/").partition("/")[0]
    return head in ("rosout", "parameter_events", "clock", "events", "hricdv", "signals", "diagnostics", "log", "scene",
                    "bond", "robot_description") or "/_" in topic or topic in ("/tf", "/tf_static")  # fmt: skip
