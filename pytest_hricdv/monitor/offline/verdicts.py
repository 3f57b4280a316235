"""Verdicts of requirements on a logged run, with numpy: equal to those of the monitors, without stepping through it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pytest_hricdv.monitor.analysis import conditions
from pytest_hricdv.monitor.attempts import Tally
from pytest_hricdv.monitor.compiler import HysteresisScope, Program, compile_formula
from pytest_hricdv.monitor.errors import unset_signals_error
from pytest_hricdv.monitor.evaluation_state import NS_PER_S, nanoseconds
from pytest_hricdv.monitor.formula import AlwaysWithin, Eventually, Formula, Holds, HoldsUntil, PastFormula
from pytest_hricdv.monitor.log import Log
from pytest_hricdv.monitor.near_miss import explained
from pytest_hricdv.monitor.offline.array_operators import Codes
from pytest_hricdv.monitor.offline.evaluator import Evaluator, Numbers, grid_of
from pytest_hricdv.monitor.offline.series import SeriesOfLog, Times
from pytest_hricdv.monitor.requirement import Requirement
from pytest_hricdv.monitor.verdict import Verdict

Positions = NDArray[np.intp]


def evaluate(requirements: Sequence[Requirement], log: Log) -> tuple[Verdict, ...]:
    """The verdicts on a logged run, in the order of the requirements.

    Raises:
        MonitorError: as from a `MonitorSet` that is fed the log: a value is missing, read before it is set, of the
            wrong type or not finite; or times go back.
    """
    return explained([_Evaluation(requirement, log).verdict() for requirement in requirements], requirements, log)


@dataclass(frozen=True)
class _Window:
    """One attempt: the positions of its window in the grid, both ends included."""

    trigger_ns: int
    deadline_ns: float
    first: int
    last: int
    started: bool
    closed: bool


class _Evaluation:
    """The evaluation of one requirement on one log."""

    def __init__(self, requirement: Requirement, log: Log) -> None:
        self._id = requirement.id
        self._formula = requirement.formula
        self._program: Program = compile_formula(requirement.formula)
        self._shows = frozenset(requirement.shows) - self._program.kinds.keys()
        self._kinds = {**dict.fromkeys(requirement.shows, float), **self._program.kinds}
        self._series = SeriesOfLog(log, self._kinds, self._program.topics)
        self._tally = Tally()
        missing = [name for name in self._program.kinds if "." not in name and not len(self._series.updates(name))]
        if missing:
            raise unset_signals_error(self._id, missing)

    def verdict(self) -> Verdict:
        """Evaluate the requirement."""
        response = self._formula.response
        parts = (self._formula.antecedent, *conditions(response))
        grid = grid_of(parts, self._series)
        if isinstance(response, Holds):
            self._start(grid)
            self._judge_episodes(response.condition)
            return self._tally.verdict(self._id, pending=0)
        start_ns, end_ns = _bounds(self._formula)
        triggers = grid[self._start(grid) // 2]
        ends = [triggers + int(bound) for bound in (start_ns, end_ns) if np.isfinite(bound)]
        starts = self._start(grid_of(parts, self._series, np.concatenate(ends)))
        windows = list(self._windows(starts, start_ns, end_ns))
        if isinstance(response, Eventually):
            pending = self._judge_liveness(response.condition, windows)
        else:
            release = response.release if isinstance(response, HoldsUntil) else None
            pending = self._judge_safety(response.condition, release, windows)
        return self._tally.verdict(self._id, pending=pending)

    def _start(self, grid: Times) -> Positions:
        """Evaluate the antecedent over a grid; returns the positions at which attempts begin."""
        self._grid = grid
        self._evaluator = Evaluator(self._id, self._series, grid, np.empty(0, np.intp))
        codes = self._evaluator.truth(self._formula.antecedent).positions()
        self._require_known_antecedent(codes)
        self._active = codes == 1
        starts = np.flatnonzero(self._active & ~_before(self._active))
        self._evaluator = Evaluator(self._id, self._series, grid, starts)
        self._tally.attempts = len(starts)
        return starts

    def _require_known_antecedent(self, codes: Codes) -> None:
        updates = [self._series.updates(source) for source in self._program.always_sources]
        evaluated = np.repeat(np.isin(self._grid, np.concatenate([np.empty(0, np.int64), *updates])), 2)[:-1]
        self._require_known(self._formula.antecedent, codes, evaluated)

    def _require_known(self, read: PastFormula, codes: Codes, where: NDArray[np.bool_]) -> None:
        faults = where & (codes < 0)
        if faults.any():
            position = int(np.argmax(faults))
            raise self._evaluator.fault(codes[position : position + 1], position // 2, read)

    def _ns(self, position: int) -> int:
        return int(self._grid[position // 2])

    # --- state responses

    def _judge_episodes(self, condition: PastFormula) -> None:
        codes = self._evaluator.truth(condition, HysteresisScope.ATTEMPT).positions()
        active = self._active
        self._require_known(condition, codes, active)
        margins = self._evaluator.robustness(condition)
        self._add_margins(margins, active)
        violated = active & (codes == 0)
        episode = np.cumsum(active & ~_before(active))
        starts = np.flatnonzero(active & ~_before(active))
        failed = set()
        for first, last in _runs(violated):
            failed.add(int(episode[first]))
            margin = np.inf if margins is None else float(margins[first : last + 1].min())
            self._add_violation(self._ns(starts[episode[first] - 1]), self._ns(first), margin, self._end_ns(last))
        self._tally.failures = len(failed)
        self._tally.passes = self._tally.attempts - len(failed)

    # --- responses in a window

    def _windows(self, starts: Positions, start_ns: float, end_ns: float) -> Iterator[_Window]:
        last = 2 * len(self._grid) - 2
        for start in starts:
            trigger_ns = self._ns(start)
            opens_ns, deadline_ns = trigger_ns + start_ns, trigger_ns + end_ns
            closed = deadline_ns <= self._series.end_ns
            yield _Window(
                trigger_ns=trigger_ns,
                deadline_ns=deadline_ns,
                first=max(int(start), 2 * int(np.searchsorted(self._grid, opens_ns))),
                last=2 * int(np.searchsorted(self._grid, deadline_ns)) if closed else last,
                started=opens_ns <= self._series.end_ns,
                closed=closed,
            )

    def _judge_liveness(self, condition: PastFormula, windows: list[_Window]) -> int:
        """Returns the number of attempts that are undecided at the end of the run."""
        codes = self._evaluator.truth(condition).positions()
        true = np.flatnonzero(codes == 1)
        read = np.zeros(len(codes), bool)
        decided: list[tuple[float, float]] = []  # time (ns), margin (s)
        for window in windows:
            first = _next(true, window.first)
            read[window.first : min(first, window.last) + 1] = True
            if first <= window.last:
                self._tally.passes += 1
                decided.append((self._ns(first), (window.deadline_ns - self._ns(first)) / NS_PER_S))
            elif window.closed:
                self._tally.failures += 1
                decided.append((window.deadline_ns, 0.0))
                self._add_violation(window.trigger_ns, int(window.deadline_ns), 0.0)
        self._require_known(condition, codes, read)
        for time_ns, margin in sorted(decided):
            self._tally.add_margin(margin, time_ns)
        return len(windows) - len(decided)

    def _judge_safety(self, condition: PastFormula, release: PastFormula | None, windows: list[_Window]) -> int:
        """Returns the number of attempts that are undecided at the end of the run."""
        scope = HysteresisScope.NEVER
        codes = self._evaluator.truth(condition, scope).positions()
        released = np.zeros(len(codes), np.int8) if release is None else self._evaluator.truth(release).positions()
        false, true = np.flatnonzero(codes == 0), np.flatnonzero(released == 1)
        condition_read, release_read = np.zeros(len(codes), bool), np.zeros(len(codes), bool)
        violated = []
        for window in windows:
            violation, end = _next(false, window.first), _next(true, window.first)
            condition_read[window.first : min(violation, end - 1, window.last) + 1] = True
            release_read[window.first : min(violation, end, window.last) + 1] = True
            if violation < end and violation <= window.last:
                violated.append((violation, window.trigger_ns))
            elif window.started:
                self._tally.passes += 1
        self._require_known(condition, codes, condition_read)
        if release is not None:
            self._require_known(release, released, release_read)
        margins = self._evaluator.robustness(condition)
        self._add_margins(margins, condition_read)
        self._tally.failures = len(violated)
        for position, trigger_ns in sorted(violated):
            self._add_violation(trigger_ns, self._ns(position), np.inf if margins is None else float(margins[position]))
        return self._tally.attempts - self._tally.passes - self._tally.failures

    # --- margins and violations

    def _add_margins(self, margins: Numbers | None, where: NDArray[np.bool_]) -> None:
        if margins is not None and where.any():
            least = int(np.argmin(np.where(where, margins, np.inf)))
            self._tally.add_margin(float(margins[least]) if where[least] else np.inf, self._ns(least))

    def _end_ns(self, last: int) -> int:
        """The last nanosecond of a position: of an instant, or of the time right after it."""
        return self._ns(last) if last % 2 == 0 else self._ns(last + 1) - 1

    def _add_violation(self, trigger_ns: int, time_ns: int, margin: float, end_ns: int | None = None) -> None:
        values = self._series.values_at(self._kinds, time_ns)
        if end_ns is not None:
            values.update(self._series.extremes(self._shows, time_ns, end_ns))
        self._tally.add_violation(trigger_ns, time_ns, values, margin)


def _bounds(formula: Formula) -> tuple[float, float]:
    """The window of a response, relative to the trigger (ns)."""
    response = formula.response
    if isinstance(response, Eventually | AlwaysWithin):
        return nanoseconds(response.start_s), nanoseconds(response.end_s)
    return 0, np.inf


def _before(marks: NDArray[np.bool_]) -> NDArray[np.bool_]:
    return np.concatenate((np.zeros(1, bool), marks[:-1]))


def _runs(marks: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """First and last position of each sequence of consecutive marks."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], marks, [False])).astype(np.int8)))
    for first, end in edges.reshape(-1, 2):
        yield int(first), int(end) - 1


def _next(positions: Positions, start: int) -> int:
    """The first of the positions that is not before `start`; the largest integer if there is none."""
    index = int(np.searchsorted(positions, start))
    return int(positions[index]) if index < len(positions) else np.iinfo(np.intp).max
