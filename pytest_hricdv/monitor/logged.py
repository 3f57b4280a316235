"""Judges logged runs: `evaluate` gives verdicts, `watch` when a condition was true, `explain` why nothing triggered.

Each run of a test ends with `explain` on its record; the suggestion of requirements uses `evaluate`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from numbers import Real

from msgspec.structs import replace

from pytest_hricdv.monitor.analysis import fields_read, names_of, names_read, topics_of, topics_read, walk
from pytest_hricdv.monitor.antecedent import near_miss
from pytest_hricdv.monitor.evaluation_state import Value, nanoseconds, seconds
from pytest_hricdv.monitor.formula import Formula
from pytest_hricdv.monitor.formula_monitor import ConditionMonitor
from pytest_hricdv.monitor.log import Log
from pytest_hricdv.monitor.monitor_set import MonitorError, MonitorSet
from pytest_hricdv.monitor.node import Kind, PastFormula
from pytest_hricdv.monitor.past_formula import On
from pytest_hricdv.monitor.requirement import Requirement
from pytest_hricdv.monitor.verdict import Verdict


def explain(verdicts: Iterable[Verdict], requirements: Iterable[Requirement], log: Log) -> tuple[Verdict, ...]:
    """The verdicts with the messages that they did not see, and with the nearest misses of untriggered requirements.

    Args:
        verdicts: the verdicts on the logged run.
        requirements: the requirements of the verdicts, in the same order.
    """
    instants, results = _instants_with_several(log), []
    for verdict, requirement in zip(verdicts, requirements, strict=True):
        miss = near_miss(requirement.formula.antecedent, log) if verdict.untriggered else verdict.near_miss
        masked = _count_masked(requirement.formula, instants)
        results.append(replace(verdict, near_miss=miss, masked_messages=masked))
    return tuple(results)


def evaluate(requirements: Sequence[Requirement], log: Log) -> tuple[Verdict, ...]:
    """The verdicts on a logged run, in the order of the requirements; untriggered ones are explained.

    Raises:
        MonitorError: as from a `MonitorSet`; or a signal of the log has not one value for each time, or a bool is
            neither 0 nor 1.
    """
    kinds: dict[str, Kind] = {}
    topics: set[str] = set()
    for requirement in requirements:
        kinds.update({**dict.fromkeys(requirement.shows, float), **names_read(requirement.formula)})
        topics |= topics_read(requirement.formula)
    monitors = MonitorSet(requirements)
    _feed(monitors, log, kinds, topics)
    return explain(monitors.finish(log.end_s), requirements, log)


def watch(condition: PastFormula, log: Log) -> ConditionMonitor:
    """The truth of a condition over a logged run, as from `MonitorSet.watch`.

    Raises:
        MonitorError: as from `evaluate`.
    """
    return watch_all([condition], log)[0]


def watch_all(conditions: Iterable[PastFormula], log: Log) -> tuple[ConditionMonitor, ...]:
    """Watch several conditions in one pass over the run."""
    conditions = tuple(conditions)
    monitors = MonitorSet()
    watchers = tuple(map(monitors.watch, conditions))
    _feed(monitors, log, names_of(conditions), topics_of(conditions))
    monitors.finish(log.end_s)
    return watchers


def _feed(monitors: MonitorSet, log: Log, kinds: Mapping[str, Kind], topics: Iterable[str]) -> None:
    """Feed the signals and messages of a log that are read."""
    signals = [name for name in kinds if "." not in name]
    for name in signals:
        _require_one_value_each(name, *log.signals.get(name, ((), ())))
    for now_ns, updates in log.instants(signals, topics):
        time_s = seconds(now_ns)
        monitors.advance(time_s)
        for name, value in updates:
            if isinstance(value, Mapping):
                monitors.message(time_s, name, value)
            else:
                monitors.signal(time_s, name, _as_type(time_s, name, value, kinds[name]))


def _require_one_value_each(name: str, times: Sequence[float], values: Sequence[Value]) -> None:
    if len(times) != len(values):
        raise MonitorError(f"{name}: expected one value for each of {len(times)} times, got {len(values)} values")


def _as_type(time_s: float, name: str, value: Value, kind: Kind) -> Value:
    """The value as the monitors want it: a log may have a bool as a number, and numbers of other libraries."""
    if kind is bool:
        if value not in (0, 1):
            raise MonitorError(f"{name} at {time_s} s is {value!r}: not a bool")
        return bool(value)
    return float(value) if isinstance(value, Real) and value == float(value) else value


Crowded = Mapping[str, Sequence[Sequence[Mapping[str, object]]]]
"""Topic -> the fields of the messages of each instant at which it has several, in the order in which they came."""


def _instants_with_several(log: Log) -> Crowded:
    """The instants of a run at which a topic has several messages."""
    instants: dict[str, list[list[Mapping[str, object]]]] = {}
    for _, group in groupby(log.messages, key=lambda message: nanoseconds(message.time_s)):
        by_topic: dict[str, list[Mapping[str, object]]] = {}
        for message in group:
            by_topic.setdefault(message.topic, []).append(message.fields)
        for topic, messages in by_topic.items():
            if len(messages) > 1:
                instants.setdefault(topic, []).append(messages)
    return instants


def _count_masked(formula: Formula, instants: Crowded) -> dict[str, int]:
    """Topic -> how many of its messages a requirement with `on(topic)` ignored.

    An instant is judged once, after all its updates, and in virtual time code takes no time: a robot that publishes
    "Failed" and then "Idle" without waiting does both at one instant, and `on(state) & state.name == "Failed"` is false
    there. A message is counted if what the requirement reads differs in the last one of the instant; with
    `last(topic.field)` it reads the one before, too.
    """
    counts = {}
    for topic, (names, seen) in what_masks(formula).items():
        count = sum(count_masked(messages, names, seen) for messages in instants.get(topic, ()))
        if count:
            counts[topic] = count
    return counts


def what_masks(formula: Formula) -> dict[str, tuple[tuple[str, ...], int]]:
    """Topic of `on(topic)` in a formula -> the fields that it reads, and how many messages of an instant it sees."""
    kinds, topics = names_read(formula), {}
    for topic in dict.fromkeys(
        node.topic for part in formula.conditions for node in walk(part) if isinstance(node, On)
    ):
        read = fields_read(kinds, topic)
        seen = 2 if read and all(read.values()) else 1
        topics[topic] = tuple(name.partition(".")[2] for name in read), seen
    return topics


def count_masked(messages: Sequence[Mapping[str, object]], names: Iterable[str], seen: int) -> int:
    """How many messages of a topic at one instant count for nothing, see `what_masks`."""
    final = messages[-1]
    return sum(any(message[name] != final[name] for name in names) for message in messages[:-seen])
