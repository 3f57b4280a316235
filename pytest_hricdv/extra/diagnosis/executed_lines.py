"""Records when a run executed which lines of the code under test, for the page of a failing test.

Tests run with coverage only. `DiagnosisFeature.after_test` reruns a test that fails in a fork of its process and traces
it line by line (`LineTracer`): runs are repeatable, so this is the same run, and tests that pass cost nothing.
`diagnose` uses `neighbour_runner` to trace the nearest passing run of a cause, which the page shows next to the failing
one. A burst is what one node executes without simulated time passing.
"""

from __future__ import annotations

import contextlib
import io
import os
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import TYPE_CHECKING

import msgspec

from pytest_hricdv._base.error_text import text_of
from pytest_hricdv.coverage.code_map import CodeMap
from pytest_hricdv.coverage.own_coverage import debugger
from pytest_hricdv.execution.case import CaseResult, RunSettings, execute
from pytest_hricdv.execution.forks import ForkError, call_in_fork
from pytest_hricdv.extra.diagnosis.records import ExecutedLines, Neighbour
from pytest_hricdv.extra.diagnosis.runs import in_fork
from pytest_hricdv.extra.diagnosis.trace import Tracer, TraceStep
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.results.timeline import timeline
from pytest_hricdv.session.replaying import TestRerunner, name_test

if TYPE_CHECKING:
    from pytest_hricdv.coverage.code_map import CodeMap

TRACED_EACH = 5
"""Maximum number of failures of each requirement that a process traces, as many as it films. More show little new."""

MAX_BURSTS = 4000
"""Number of bursts kept of a run. Chosen: a run of the table has some 800; as text, 4,000 are some 40 kB."""

MAX_LINES = 200
"""Number of lines kept of a burst, the last ones. Chosen: more than a screen."""

AFTER_S = 10.0
"""If not all bursts are kept, the kept ones end this time (s) after the first violation, as far as the page shows."""


@dataclass(frozen=True)
class _Burst:
    time_s: float
    node: int
    lines: tuple[tuple[str, int], ...]


def collect_executed_lines(steps: Iterable[TraceStep], violation_s: float | None) -> ExecutedLines:
    """The executed lines of a run that are kept.

    Args:
        violation_s: time of the first violation (s); None without one.
    """
    bursts = [*_bursts(steps)]
    kept = _around(bursts, violation_s)
    files: dict[str, int] = {}
    texts: dict[str, int] = {}
    nodes: dict[int, list[str]] = {}
    for burst in kept:
        number = texts.setdefault(_text(burst.lines, files), len(texts))
        nodes.setdefault(burst.node, []).append(f"{round(burst.time_s, 4):g} {number}")
    is_cut = len(kept) < len(bursts)
    return ExecutedLines(
        files=tuple(files),
        bursts=tuple(texts),
        nodes=tuple(" ".join(nodes[node]) for node in sorted(nodes)),
        from_s=round(kept[0].time_s, 3) if is_cut else 0.0,
        until_s=round(kept[-1].time_s, 3) if is_cut else None,
    )


def _bursts(steps: Iterable[TraceStep]) -> Iterator[_Burst]:
    for (time_s, node), group in groupby(steps, key=lambda step: (step.time_s, step.node)):
        lines = [(step.file, step.line) for step in group]
        yield _Burst(time_s, node, tuple(lines[-MAX_LINES:]))


def _around(bursts: Sequence[_Burst], violation_s: float | None) -> Sequence[_Burst]:
    """The bursts to keep: until shortly after the violation, or else the last ones."""
    if len(bursts) <= MAX_BURSTS:
        return bursts
    end = len(bursts)
    if violation_s is not None:
        end = sum(burst.time_s <= violation_s + AFTER_S for burst in bursts)
    return bursts[max(0, end - MAX_BURSTS) : max(end, MAX_BURSTS)]


def _text(lines: Sequence[tuple[str, int]], files: dict[str, int]) -> str:
    parts, last = [], ""
    for file, line in lines:
        parts.append(str(line) if file == last else f"{files.setdefault(file, len(files))}:{line}")
        last = file
    return " ".join(parts)


class LineTracer:
    """Traces the failures of one process."""

    def __init__(self, settings: RunSettings, code: CodeMap) -> None:
        self._settings = settings
        self._code = code
        self._traced: Counter[str] = Counter()

    def trace(self, result: CaseResult) -> ExecutedLines:
        """Rerun the test of this result, traced."""
        failed = result.failed or ("",)
        if all(self._traced[name] >= TRACED_EACH for name in failed):
            return ExecutedLines(
                note=f"not traced: {TRACED_EACH} failures of {' and '.join(failed) or 'an assertion'} had been traced "
                "in this process; run this test alone to see its lines"
            )
        self.count(failed)
        return self._in_fork(result) if hasattr(os, "fork") else self._here(result)

    def count(self, failed: Iterable[str]) -> None:
        """Count a traced failure of these requirements."""
        self._traced.update(failed)

    def _in_fork(self, result: CaseResult) -> ExecutedLines:
        try:
            made = call_in_fork(lambda: msgspec.json.encode(self._here(result)))
        except ForkError as error:
            return ExecutedLines(note=f"not traced: the process that traced it {error}")
        lines = msgspec.json.decode(made, type=ExecutedLines | None)
        return lines or ExecutedLines(note="not traced: it was interrupted")

    def _here(self, result: CaseResult) -> ExecutedLines:
        tracing = Tracer(self._code)
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                again = execute(self._settings.with_measurement(tracing), result.test, begun=tracing.begin)
        except Exception as error:
            return ExecutedLines(note=f"not traced: {type(error).__name__}: {text_of(error)}")
        lines = collect_executed_lines(tracing.steps(), first_violation_s(result))
        if again.record.sha256 == result.record.sha256:
            return lines
        return msgspec.structs.replace(lines, note="the traced run differs from this one: compare with care")


def first_violation_s(result: CaseResult) -> float | None:
    """The time of the first violation of a run (s); None without one."""
    times = (violation.time_s for verdict in result.verdicts for violation in verdict.violations)
    return min(times, default=None)


Showing = Callable[[ConcreteTest], Neighbour | None]
"""Runs a test for the page; None if the run did not end."""


def neighbour_runner(rerunner: TestRerunner, code: CodeMap) -> Showing:
    """A function that runs a test traced, in a fork where the system has one, and returns what the page shows.

    Args:
        rerunner: runs tests.
        code: the code under test.
    """
    return lambda test: in_fork(rerunner, lambda: _neighbour(rerunner, code, name_test(test, "neighbour")), Neighbour)


def _neighbour(rerunner: TestRerunner, code: CodeMap, test: ConcreteTest) -> Neighbour | None:
    tracing = None if debugger() or not code.files else Tracer(code)
    if tracing is None:
        result = rerunner.run(test)
    else:
        result = replace(rerunner, settings=rerunner.settings.with_measurement(tracing)).run(test, tracing.begin)
    if result is None:
        return None
    return Neighbour(
        timeline=timeline(result.record, result.verdicts, result.sim_s),
        abstract=tuple(action.command for action in result.test.actions),
        begun=tuple(
            (round(time_s, 3), number) for time_s, number in zip(result.action_times_s, result.begun, strict=True)
        ),
        lines=None if tracing is None else collect_executed_lines(tracing.steps(), None),
    )
