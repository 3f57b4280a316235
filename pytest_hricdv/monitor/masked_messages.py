"""Messages that a requirement ignores because a later one of their topic came at the same instant."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby

from pytest_hricdv.monitor.analysis import fields_read, names_read, walk
from pytest_hricdv.monitor.evaluation_state import nanoseconds
from pytest_hricdv.monitor.formula import Formula
from pytest_hricdv.monitor.log import Log, Message
from pytest_hricdv.monitor.past_formula import On

Crowded = Mapping[str, Sequence[Sequence[Message]]]
"""Topic -> the messages of each instant at which it has several, in the order in which they came."""


def crowded_instants(log: Log) -> Crowded:
    """The instants of a run at which a topic has several messages."""
    instants: dict[str, list[list[Message]]] = {}
    for _, group in groupby(log.messages, key=lambda message: nanoseconds(message.time_s)):
        by_topic: dict[str, list[Message]] = {}
        for message in group:
            by_topic.setdefault(message.topic, []).append(message)
        for topic, messages in by_topic.items():
            if len(messages) > 1:
                instants.setdefault(topic, []).append(messages)
    return instants


def masked_messages(formula: Formula, instants: Crowded) -> dict[str, int]:
    """Topic -> how many of its messages a requirement with `on(topic)` ignored.

    An instant is judged once, after all its updates, and in virtual time code takes no time: a robot that publishes
    "Failed" and then "Idle" without waiting does both at one instant, and `on(state) & state.name == "Failed"` is false
    there. A message is counted if what the requirement reads differs in the last one of the instant; with
    `last(topic.field)` it reads the one before, too.
    """
    parts = formula.conditions
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
