"""`MonitorSet`: the monitors of the requirements and conditions of one run, fed with its messages and signals.

Each run of a test has one, and so has each judgement of a log; `finish` gives the verdicts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping

from pytest_hricdv.monitor.analysis import fields_read
from pytest_hricdv.monitor.evaluation_state import (
    LAST_NS,
    NS_PER_S,
    EvaluationState,
    Nanoseconds,
    UnknownValueError,
    Value,
    Values,
    seconds,
)
from pytest_hricdv.monitor.formula_monitor import ConditionMonitor, FormulaMonitor
from pytest_hricdv.monitor.node import Kind, PastFormula, field_of
from pytest_hricdv.monitor.program import compile_condition
from pytest_hricdv.monitor.requirement import Requirement
from pytest_hricdv.monitor.requirement_monitor import RequirementMonitor, monitor_of
from pytest_hricdv.monitor.verdict import Outcome, Verdict


class MonitorError(RuntimeError):
    """The monitors were fed wrongly: time went back, or a value is NaN, of the wrong type, or missing."""


class MonitorSet:
    """Monitors one run. Feed it in the order of time; updates with one time stamp are one instant, in any order.

    An instant is judged once, after all its updates: at the first later time stamp, or at the end. If a signal or topic
    is updated several times at one instant, the last update counts. Signals keep their value between updates. Times are
    rounded to whole nanoseconds. Signals and messages that no requirement reads are ignored.

    Reading a value before it is set is an error. `&` and `|` are evaluated from left to right and stop as soon as the
    result is known, so `on(reading) & reading.gaze` is safe before the first reading.

    Args:
        most: number of violations and triggers of each that are kept, the first ones; the others are only counted.

    >>> from pytest_hricdv.monitor import MonitorSet, Requirement, Vocabulary, parse_formula
    >>> text = "always(closing -> distance >= 0.05)"
    >>> formula = parse_formula(text, Vocabulary(signals={"closing": bool, "distance": float}))
    >>> monitors = MonitorSet([Requirement("R3", "No crushing", "", text, formula)])
    >>> monitors.signal(0.0, "distance", 0.3)
    >>> monitors.signal(0.0, "closing", True)
    >>> monitors.signal(1.5, "distance", 0.04)
    >>> [verdict] = monitors.finish(2.0)
    >>> verdict.verdict, verdict.violations[0].time_s, verdict.margin
    ('Failed', 1.5, -0.010000000000000002)
    """

    def __init__(self, requirements: Iterable[Requirement] = (), *, most: float = math.inf) -> None:
        self._values = Values()
        self._arrived: dict[str, int] = {}
        self._requirements: dict[RequirementMonitor, str] = {}
        self._monitors: dict[FormulaMonitor, str] = {}  # -> what errors call it
        self._kinds: dict[str, Kind] = {}
        self._fields: dict[str, dict[str, bool]] = {}  # topic -> what is read of it (`analysis.fields_read`)
        # Source -> monitors to evaluate on its updates; with False, only while a trigger of the monitor is open.
        self._monitors_by_source: dict[str, list[tuple[FormulaMonitor, bool]]] = {}
        self._dirty: dict[FormulaMonitor, None] = {}  # used as an ordered set
        self._now_s = -math.inf
        self._now_ns: Nanoseconds = -math.inf
        self._wake_ns: Nanoseconds = math.inf
        self._started = False
        self._finished = False
        for requirement in requirements:
            monitor = monitor_of(requirement, self._values, self._arrived)
            monitor.keep_at_most(most)
            self._requirements[monitor] = requirement.id
            self._add(monitor, requirement.id)

    def watch(self, condition: PastFormula, changed: Callable[[float, bool], None] | None = None) -> ConditionMonitor:
        """Follow the truth of a condition, for what is not a requirement; to be called before the first update.

        Args:
            condition: from `parse_condition`, or `.past` of a condition built in Python.
            changed: called with the time (s) and True when it becomes true, and with the time and False when it
                becomes false; at single instants (`on(topic)`) with both. All calls of a set are in the order of time.
                An instant is judged at the first later time stamp, so a call comes that much later than its time.
                Several messages of a topic at one instant are one instant of `on(topic)`.

        Returns:
            The monitor, which is asked with `holds`, `holds_at(time_s)` and `began_s`, also after the run.

        Raises:
            MonitorError: there was an update before.

        >>> from pytest_hricdv.monitor import MonitorSet, Vocabulary, parse_condition
        >>> text = 'state == "Move_hand"'
        >>> monitors = MonitorSet()
        >>> moving = monitors.watch(parse_condition(text, Vocabulary(messages={"state": {"name": str}})), print)
        >>> monitors.message(1.0, "state", {"name": "Move_hand"})
        >>> monitors.message(4.0, "state", {"name": "Idle"})
        1.0 True
        >>> _ = monitors.finish(9.0)
        4.0 False
        >>> moving.began_s, moving.holds_at(0.5), moving.holds_at(2.0), moving.holds
        ((1.0,), False, True, False)
        """
        if self._now_s > -math.inf:
            raise MonitorError(f"watch {condition}: there was an update at {self._now_s} s; watch before the run")
        monitor = ConditionMonitor(compile_condition(condition), EvaluationState(self._values, self._arrived), changed)
        self._add(monitor, f"condition {condition}")
        return monitor

    def _add(self, monitor: FormulaMonitor, name: str) -> None:
        self._monitors[monitor] = name
        self._kinds.update(monitor.kinds)
        for source, kind in monitor.kinds.items():
            if "." in source:
                self._kinds[field_of(source)] = kind
            else:
                self._monitors_by_source.setdefault(source, [])
        for topic in sorted(monitor.program.topics):
            self._fields[topic] = fields_read(self._kinds, topic)
        always = monitor.program.always_sources
        for source in sorted(always.union(monitor.program.trigger_sources, monitor.shows)):
            self._monitors_by_source.setdefault(source, []).append((monitor, source in always))

    def message(self, time_s: float, topic: str, fields: Mapping[str, object]) -> None:
        """A message arrived.

        Args:
            fields: the message's fields; the fields that requirements read are required, others are ignored.

        Raises:
            MonitorError: time goes back, or a field is missing, of the wrong type, NaN or infinite.
        """
        if time_s != self._now_s:
            self._advance(time_s)
        if topic not in self._fields:
            return
        for name, keep_last in self._fields[topic].items():
            field = name.partition(".")[2]
            if field not in fields:
                present = ", ".join(fields) or "none"
                raise MonitorError(f"a message {topic!r} at {time_s} s has no field {field!r}; its fields: {present}")
            self._values.set_field(name, self._check_value(time_s, name, fields[field]), keep_last=keep_last)
        self._arrived[topic] = self._arrived.get(topic, 0) + 1
        self._mark_dirty(f"on({topic})")

    def signal(self, time_s: float, name: str, value: Value) -> None:
        """A signal has a new value, and keeps it until its next update.

        Args:
            value: its value, in the signal's unit.

        Raises:
            MonitorError: time goes back, or the value is of the wrong type, NaN or infinite.
        """
        if time_s != self._now_s:
            self._advance(time_s)
        readers = self._monitors_by_source.get(name)
        if readers is None:
            return
        # This runs at every physics substep, so the common case calls no function. `value - value` is 0 only for a
        # finite number.
        kind = self._kinds[name]
        if type(value) is not kind or (kind is not str and value - value != 0):  # type: ignore[operator]
            value = self._check_value(time_s, name, value)
        values = self._values
        if name in values and values[name] == value:  # the same again: nothing can have changed
            return
        values[name] = value
        for monitor, always in readers:
            if always or monitor.active:
                self._dirty[monitor] = None

    def advance(self, time_s: float) -> None:
        """Simulated time has reached `time_s`: everything before it is judged. Raises MonitorError: time goes back."""
        if time_s != self._now_s:
            self._advance(time_s)

    @property
    def is_instant_open(self) -> bool:
        """Whether something happened at the present instant, which is judged once time has passed it."""
        return bool(self._dirty)

    def next_deadline_s(self) -> float | None:
        """The latest deadline (s) of the open `eventually` triggers; None if there is none.

        A trigger that begins at the present instant is included only after the next `advance`, and a deadline is
        decided once time has passed it. So a run is over when this is None or not later than the present.
        """
        deadlines = [deadline for monitor in self._requirements if (deadline := monitor.deadline_ns()) is not None]
        return seconds(max(deadlines)) if deadlines else None

    def so_far(self) -> dict[str, Outcome]:
        """Requirement id -> its verdict if all open triggers remained undecided. Judges nothing."""
        return {requirement: monitor.outcome_so_far() for monitor, requirement in self._requirements.items()}

    def finish(self, time_s: float) -> tuple[Verdict, ...]:
        """The run ended at `time_s` (s): the verdicts, in the order of the requirements.

        Raises:
            MonitorError: time goes back, the run was finished before, or a signal that a requirement reads never had a
                value.
        """
        self.advance(time_s)
        self._require_open(time_s)
        self._require_all_signals()
        if not self._started:
            self._start(last=True)
        for monitor in self._monitors:
            if monitor in self._dirty or monitor.wake_ns == self._now_ns:
                self._evaluate(monitor, self._now_ns, last=True)
        self._finished = True
        return tuple(monitor.finish(name, self._now_ns) for monitor, name in self._requirements.items())

    def _advance(self, time_s: float) -> None:
        """Judge the present instant and everything that is due before `time_s`, and make `time_s` the present."""
        # Rounded first: two times that are less than a nanosecond apart are one instant, not a step back.
        self._require_open(time_s)
        try:
            now_ns = round(time_s * NS_PER_S)
        except (ValueError, OverflowError):
            raise MonitorError(f"a time has to be a finite number of seconds, got {time_s}") from None
        if now_ns > LAST_NS:
            raise MonitorError(f"a time has to be at most {seconds(LAST_NS):.1e} s, got {time_s}")
        if now_ns > self._now_ns:
            if not self._started and self._now_ns > -math.inf:
                self._start(last=False)
            is_due = self._wake_ns <= self._now_ns
            if is_due:
                # A monitor that is due at this very instant sees all its messages, also those read by responses only.
                for monitor in self._monitors:
                    if monitor.wake_ns <= self._now_ns:
                        self._dirty[monitor] = None
            if self._dirty:
                for monitor in self._dirty:
                    self._evaluate(monitor, self._now_ns, last=False)
                    if monitor.wake_ns < self._wake_ns:
                        self._wake_ns = monitor.wake_ns
                self._dirty.clear()
            if is_due:
                self._wake_ns = self._next_wake_ns()
            if self._arrived:  # cleared in place: all monitors share it
                self._arrived.clear()
            if self._wake_ns < now_ns:
                self._wake(now_ns)
            self._now_ns = now_ns
        elif now_ns < self._now_ns:
            raise MonitorError(f"back in time: an update at {time_s} s after one at {self._now_s} s")
        self._now_s = time_s

    def _start(self, *, last: bool) -> None:
        """Start the monitors that read no update of the first instant of the run."""
        self._started = True
        for monitor in self._monitors:
            if monitor not in self._dirty:
                self._evaluate(monitor, self._now_ns, last=last, first=True)
                self._wake_ns = min(self._wake_ns, monitor.wake_ns)

    def _wake(self, until_ns: Nanoseconds) -> None:
        """Evaluate the monitors at their wake-up times before `until_ns`, in the order of time."""
        while self._wake_ns < until_ns:
            now_ns = self._wake_ns
            for monitor in self._monitors:
                if monitor.wake_ns == now_ns:
                    self._evaluate(monitor, now_ns, last=False)
            self._wake_ns = self._next_wake_ns()

    def _next_wake_ns(self) -> Nanoseconds:
        # A loop instead of min(), which takes twice as long: with short windows this runs at every event.
        next_ns: Nanoseconds = math.inf
        for monitor in self._monitors:
            if monitor.wake_ns < next_ns:
                next_ns = monitor.wake_ns
        return next_ns

    def _evaluate(self, monitor: FormulaMonitor, now_ns: Nanoseconds, *, last: bool, first: bool = False) -> None:
        try:
            monitor.evaluate(now_ns, last=last, first=first)
        except UnknownValueError as unknown:
            advice = "signals need a value from the start of the run; guard a field with on(topic) & ..."
            problem = f"reads {unknown.name}, which has no value yet; {advice}"
            raise MonitorError(f"{self._monitors[monitor]} at {seconds(now_ns)} s {problem}") from None
        except ArithmeticError as error:
            raise MonitorError(f"{self._monitors[monitor]} at {seconds(now_ns)} s: {error}") from None

    def _mark_dirty(self, source: str) -> None:
        for monitor, always in self._monitors_by_source.get(source, ()):
            if always or monitor.active:
                self._dirty[monitor] = None

    def _check_value(self, time_s: float, name: str, value: object) -> Value:
        kind = self._kinds[name]
        if isinstance(value, bool | str) and isinstance(value, kind):
            return value
        if kind is float and isinstance(value, float | int) and not isinstance(value, bool):
            if math.isfinite(value):
                # Whole numbers that no float is stay as they are: two identifiers of 64 bits would be one.
                return value if value != (number := float(value)) else number
            raise MonitorError(f"{name} at {time_s} s is {value}: not a finite number")
        raise MonitorError(f"{name} at {time_s} s: expected a {kind.__name__}, got {value!r} ({type(value).__name__})")

    def _require_all_signals(self) -> None:
        for monitor, requirement in self._monitors.items():
            missing = [name for name in monitor.program.kinds if "." not in name and name not in self._values]
            if missing:
                problem = f"reads {', '.join(missing)}, which had no value in the whole run: feed every signal"
                raise MonitorError(f"{requirement} {problem}")

    def _require_open(self, time_s: float) -> None:
        if self._finished:
            raise MonitorError(f"an update at {time_s} s after the run was finished; a MonitorSet is for one run")
