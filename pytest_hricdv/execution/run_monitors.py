"""Connects runs to the monitors of their requirements.

`case.execute` uses `MonitorFeed` to forward messages and signals of a run to them. Afterwards, `mark_unknown` marks
violations outside of the condition under which a violation is declared as known.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from msgspec.structs import replace

from pytest_hricdv._base.message import nearest
from pytest_hricdv.execution.execution_feature import Watcher
from pytest_hricdv.monitor import Criterion, Log, PastFormula, Requirement, Verdict, Vocabulary, watch
from pytest_hricdv.monitor.formula_monitor import ConditionMonitor
from pytest_hricdv.runtime import Record
from pytest_hricdv.runtime.record import Value

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too


class MonitorFeed:
    """Forwards the events of a record that the vocabulary names to monitors, with numbers as floats."""

    def __init__(self, monitors: Watcher, vocabulary: Vocabulary) -> None:
        self._monitors = monitors
        self._fields = {topic: dict(fields) for topic, fields in vocabulary.messages.items()}
        self._signals = dict(vocabulary.signals)

    def message(self, time_s: float, topic: str, fields: Mapping[str, Value]) -> None:
        """See `runtime.record.Listener`. A field that is not as its class declares it is a TypeError."""
        kinds = self._fields.get(topic)
        if kinds is None:
            return  # a topic of ROS 2 that the testbench does not declare, so no requirement names it
        for name, kind in kinds.items():
            value = fields.get(name)
            if value is None or not (_is_of(kind, value) or (kind is not str and isinstance(value, int))):
                raise TypeError(f"{topic}.{name} is {value!r} at {time_s:.6f} s: declared as {kind.__name__}")
        self._monitors.message(time_s, topic, {name: kind(fields[name]) for name, kind in kinds.items()})

    def signal(self, time_s: float, name: str, value: float | bool | str) -> None:
        """See `runtime.record.Listener`.

        Raises:
            KeyError: the testbench did not declare such a signal.
            TypeError: it declared it with another type.
        """
        kind = self._signals.get(name)
        if kind is None:
            near = nearest(name, self._signals)
            raise KeyError(f"signal {name!r} is recorded but not declared in the testbench's signals{near}")
        if not _is_of(kind, value):
            where = f"signal {name} is {value!r} at {time_s:.6f} s"
            raise TypeError(f"{where}: the testbench declares it as {kind.__name__}")
        self._monitors.signal(time_s, name, value)


def _is_of(kind: type, value: Value) -> bool:
    """Whether a value is of a declared type; a whole number is a float, a bool is none."""
    if kind is float:
        return isinstance(value, float | int) and not isinstance(value, bool)
    return isinstance(value, kind)


def formulas(requirements: Iterable[Criterion]) -> tuple[Requirement, ...]:
    """The requirements that are formulas, which monitors evaluate."""
    return tuple(criterion for criterion in requirements if isinstance(criterion, Requirement))


def log_of(record: Record, end_s: float) -> Log:
    """The log that requirements are judged on: a record without its disturbances."""
    messages = tuple(message for message in record.messages if not message.is_disturbance)
    return Log({**record.signals, **record.texts}, messages, end_s)


def mark_unknown(verdict: Verdict, known_when: Mapping[str, PastFormula], log: Log) -> Verdict:
    """Mark the violations of a verdict that are outside of the condition under which they are known."""
    if not verdict.violations or verdict.requirement not in known_when:
        return verdict
    return mark_outside(verdict, watch(known_when[verdict.requirement], log))


def mark_outside(verdict: Verdict, condition: ConditionMonitor | None) -> Verdict:
    """Mark the violations at times at which a condition did not hold; without its monitor, all of them."""
    violations = (
        replace(violation, outside=condition is None or not condition.holds_at(violation.time_s))
        for violation in verdict.violations
    )
    return replace(verdict, violations=tuple(violations))
