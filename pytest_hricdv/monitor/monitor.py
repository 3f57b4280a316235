"""All requirements of a run watched at once, fed with its messages and signals."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from pytest_hricdv.monitor.attempts import AttemptMonitor, monitor_of
from pytest_hricdv.monitor.errors import MonitorError, UnknownValueError, never_a_value, no_value_yet
from pytest_hricdv.monitor.requirement import Requirement
from pytest_hricdv.monitor.verdict import Outcome, Verdict
from pytest_hricdv.monitor.view import NS_PER_S, Nanoseconds, Values, seconds


class MonitorSet:
    """Watches one run. Feed it in the order of time; updates with one time stamp are one instant, in any order.

    An instant is judged once, after all its updates: when a later time stamp comes, or at the end. Of several values
    or messages of one name at one instant the last counts. Signals keep their value between updates. Times are kept as
    whole nanoseconds. What no requirement reads is ignored.

    A value that is read before there is one is an error. `&` and `|` are evaluated from left to right, and no further
    than needed, so `on(reading) & reading.gaze` is safe before the first reading.

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

    def __init__(self, requirements: Iterable[Requirement]) -> None:
        self._values = Values()
        self._arrived: set[str] = set()
        self._monitors: dict[AttemptMonitor, str] = {
            monitor_of(requirement, self._values, self._arrived): requirement.id for requirement in requirements
        }
        self._kinds: dict[str, type[bool] | type[float]] = {}
        for monitor in self._monitors:
            self._kinds.update(monitor.kinds)
        self._topics = frozenset().union(*(monitor.program.topics for monitor in self._monitors))
        self._fields = {topic: [n for n in self._kinds if n.startswith(f"{topic}.")] for topic in self._topics}
        self._watchers = self._index_watchers()
        self._dirty: dict[AttemptMonitor, None] = {}  # a set that keeps its order
        self._now_s = -math.inf
        self._now_ns: Nanoseconds = -math.inf
        self._wake_ns: Nanoseconds = math.inf
        self._started = False
        self._finished = False

    def _index_watchers(self) -> dict[str, list[tuple[AttemptMonitor, bool]]]:
        """Source -> monitors to evaluate when it is updated; and whether always, or only while an attempt is open."""
        watchers: dict[str, list[tuple[AttemptMonitor, bool]]] = {name: [] for name in self._kinds if "." not in name}
        for monitor in self._monitors:
            always = monitor.program.always_sources
            for source in sorted(always.union(monitor.program.attempt_sources, monitor.shows)):
                watchers.setdefault(source, []).append((monitor, source in always))
        return watchers

    def message(self, time_s: float, topic: str, fields: Mapping[str, object]) -> None:
        """A message arrived.

        Args:
            time_s: simulated time (s).
            topic: of the message.
            fields: its fields; those that requirements read have to be there, others are ignored.

        Raises:
            MonitorError: back in time; a field missing, of the wrong type, NaN or infinite.
        """
        if time_s != self._now_s:
            self._advance(time_s)
        if topic not in self._topics:
            return
        for name in self._fields[topic]:
            field = name.partition(".")[2]
            if field not in fields:
                came = ", ".join(fields) or "none"
                raise MonitorError(f"a message {topic!r} at {time_s} s has no field {field!r}; its fields: {came}")
            self._values[name] = self._checked(time_s, name, fields[field])
        self._arrived.add(topic)
        self._mark(f"on({topic})")

    def signal(self, time_s: float, name: str, value: float | bool) -> None:
        """A signal has a new value, which it keeps until the next update.

        Args:
            time_s: simulated time (s).
            name: of the signal.
            value: in the signal's unit.

        Raises:
            MonitorError: back in time; a value of the wrong type, NaN or infinite.
        """
        if time_s != self._now_s:
            self._advance(time_s)
        watchers = self._watchers.get(name)
        if watchers is None:
            return
        # This is called at every physics substep: the common case goes through without a call. Only a finite number
        # taken from itself is 0.
        if type(value) is not self._kinds[name] or value - value != 0:
            value = self._checked(time_s, name, value)
        values = self._values
        if name in values and values[name] == value:
            return
        values[name] = value
        for monitor, always in watchers:
            if always or monitor.active:
                self._dirty[monitor] = None

    def advance(self, time_s: float) -> None:
        """Say that simulated time has reached `time_s`, so that everything before it is judged.

        Raises:
            MonitorError: back in time.
        """
        if time_s != self._now_s:
            self._advance(time_s)

    def next_deadline_s(self) -> float | None:
        """The time (s) to which the run has to go on before every monitor is quiet; None if all are.

        It is the latest deadline of the open `eventually` attempts. An attempt that begins at the present instant shows
        up when time has moved on (see `advance`), and a deadline is decided once time has passed it, so a run is over
        when this is None or not later than the present.
        """
        deadlines = [deadline for monitor in self._monitors if (deadline := monitor.deadline_ns()) is not None]
        return seconds(max(deadlines)) if deadlines else None

    def so_far(self) -> dict[str, Outcome]:
        """Requirement -> what its verdict would be now, with every open attempt left undecided. Judges nothing."""
        return {requirement: monitor.so_far() for monitor, requirement in self._monitors.items()}

    def finish(self, time_s: float) -> tuple[Verdict, ...]:
        """The run ended at `time_s` (s): the verdicts, in the order of the requirements.

        Raises:
            MonitorError: back in time; finished before; a signal that a requirement reads never had a value.
        """
        self.advance(time_s)
        self._require_open(time_s)
        self._require_every_signal()
        if not self._started:
            self._start(last=True)
        for monitor in self._monitors:
            if monitor in self._dirty or monitor.wake_ns == self._now_ns:
                self._evaluate(monitor, self._now_ns, last=True)
        self._finished = True
        return tuple(monitor.finish(requirement, self._now_ns) for monitor, requirement in self._monitors.items())

    def _advance(self, time_s: float) -> None:
        """Judge the present instant and what falls due up to `time_s`, and make that the present."""
        self._require_open(time_s)
        try:
            now_ns = round(time_s * NS_PER_S)
        except (ValueError, OverflowError):
            raise MonitorError(f"a time has to be a finite number of seconds, got {time_s}") from None
        if now_ns > self._now_ns:
            if not self._started and self._now_ns > -math.inf:
                self._start(last=False)
            if self._wake_ns <= self._now_ns:
                # What falls due at this very instant sees its messages, too, even those that only a response reads.
                self._dirty.update((monitor, None) for monitor in self._monitors if monitor.wake_ns <= self._now_ns)
            if self._dirty:
                for monitor in self._dirty:
                    self._evaluate(monitor, self._now_ns, last=False)
                    self._wake_ns = min(self._wake_ns, monitor.wake_ns)
                self._dirty.clear()
            if self._arrived:
                self._arrived.clear()
            if self._wake_ns < now_ns:
                self._wake(now_ns)
            self._now_ns = now_ns
        elif now_ns < self._now_ns:
            raise MonitorError(f"back in time: an update at {time_s} s after one at {self._now_s} s")
        self._now_s = time_s

    def _start(self, *, last: bool) -> None:
        """Begin history at the first instant of the run for the monitors, too, that read no update of it."""
        self._started = True
        for monitor in self._monitors:
            if monitor not in self._dirty:
                self._evaluate(monitor, self._now_ns, last=last, first=True)
                self._wake_ns = min(self._wake_ns, monitor.wake_ns)

    def _wake(self, until_ns: Nanoseconds) -> None:
        """Evaluate the monitors at the times, before `until_ns`, at which they have to be though nothing is updated."""
        for monitor in self._monitors:
            while monitor.wake_ns < until_ns:
                self._evaluate(monitor, monitor.wake_ns, last=False)
        self._wake_ns = min((monitor.wake_ns for monitor in self._monitors), default=math.inf)

    def _evaluate(self, monitor: AttemptMonitor, now_ns: Nanoseconds, *, last: bool, first: bool = False) -> None:
        try:
            monitor.evaluate(now_ns, last=last, first=first)
        except UnknownValueError as unknown:
            raise no_value_yet(self._monitors[monitor], seconds(now_ns), unknown.name) from None
        except ArithmeticError as error:
            raise MonitorError(f"{self._monitors[monitor]} at {seconds(now_ns)} s: {error}") from None

    def _mark(self, source: str) -> None:
        for monitor, always in self._watchers.get(source, ()):
            if always or monitor.active:
                self._dirty[monitor] = None

    def _checked(self, time_s: float, name: str, value: object) -> float | bool:
        kind = self._kinds[name]
        if kind is bool and isinstance(value, bool):
            return value
        if kind is float and isinstance(value, float | int) and not isinstance(value, bool):
            if math.isfinite(value):
                return float(value)
            raise MonitorError(f"{name} at {time_s} s is {value}: not a finite number")
        raise MonitorError(f"{name} at {time_s} s: expected a {kind.__name__}, got {value!r} ({type(value).__name__})")

    def _require_every_signal(self) -> None:
        for monitor, requirement in self._monitors.items():
            missing = [name for name in monitor.program.kinds if "." not in name and name not in self._values]
            if missing:
                raise never_a_value(requirement, missing)

    def _require_open(self, time_s: float) -> None:
        if self._finished:
            raise MonitorError(f"an update at {time_s} s after the run was finished; a MonitorSet watches one run")
