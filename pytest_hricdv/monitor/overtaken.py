"""Messages that a requirement asks for and does not see, as another one of their topic came at the same instant.

An instant is judged once, after all its updates, and in virtual time code takes no time: a robot that says "Failed" and
then "Idle" without waiting says both at one instant, and `on(state) & state.name == "Failed"` is false there. Nobody
would see it, so it is counted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby

from pytest_hricdv.monitor.analysis import conditions, fields_read, names_read, walk
from pytest_hricdv.monitor.evaluation_state import nanoseconds
from pytest_hricdv.monitor.formula import Formula, On
from pytest_hricdv.monitor.log import Log, Message

Crowded = Mapping[str, Sequence[Sequence[Message]]]
"""Topic -> the messages of each instant at which it has several, in the order in which they came."""


def crowded(log: Log) -> Crowded:
    """The instants of a run at which a topic has several messages."""
    made: dict[str, list[list[Message]]] = {}
    for _, group in groupby(log.messages, key=lambda message: nanoseconds(message.time_s)):
        by_topic: dict[str, list[Message]] = {}
        for message in group:
            by_topic.setdefault(message.topic, []).append(message)
        for topic, messages in by_topic.items():
            if len(messages) > 1:
                made.setdefault(topic, []).append(messages)
    return made


def overtaken(formula: Formula, instants: Crowded) -> dict[str, int]:
    """Topic -> how many of its messages a requirement with `on(topic)` did not see, as what it reads was other in the
    last message of their instant. With `last(topic.field)` it sees the one before, too.
    """
    parts = (formula.antecedent, *conditions(formula.response))
    kinds, counts = names_read(formula), {}
    for topic in dict.fromkeys(node.topic for part in parts for node in walk(part) if isinstance(node, On)):
        read = fields_read(kinds, topic)
        seen = 2 if read and all(read.values()) else 1
        names = [name.partition(".")[2] for name in read]
        count = 0
        for messages in instants.get(topic, ()):
            final = messages[-1].fields
            count += sum(any(message.fields[name] != final[name] for name in names) for message in messages[:-seen])
        if count:
            counts[topic] = count
    return counts
