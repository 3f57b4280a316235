"""`--hri-break-on-violation`: stops in a debugger, inside the code under test, when a requirement is violated.

A monitor judges an instant when it is over; by then, the code that acted in it has continued. But runs are repeatable,
so `BreakpointRunner`, which `TestRunner` uses with this option, runs the test twice: once to find the violation, and
again up to the last event of that instant. There, the debugger shows the stack of the node that acted, and `Now`.
"""

from __future__ import annotations

import builtins
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType

import pytest
from _pytest.debugging import pytestPDB

from pytest_hricdv.coverage.own_coverage import debugger
from pytest_hricdv.execution.case import CaseResult, RunSettings, execute
from pytest_hricdv.execution.faults import CodeUnderTest
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.report.formatting import seconds
from pytest_hricdv.runtime.record import Value

NAME = "hri_state"
"""Name of the variable in the debugger that holds `Now`, the instant at which the run is stopped."""

_PACKAGE = Path(__file__).parents[1]


@dataclass(frozen=True)
class Now:
    """The instant at which a run is stopped; the debugger has it as `hri_state`.

    Args:
        requirement: the requirement that is violated.
        time_s: simulated time (s).
        signals: name -> value.
        messages: topic -> fields of its last message.
        state: the last state that the code under test published; empty if the testbench names no state.
        verdicts: requirement -> verdict of the whole run.
        nodes: nodes of the code under test that wait, by name.
    """

    requirement: str
    time_s: float
    signals: Mapping[str, Value]
    messages: Mapping[str, Mapping[str, Value]]
    state: str
    verdicts: Mapping[str, str]
    nodes: Sequence[str]


@dataclass
class EventCounter:
    """Numbers the events of a run, as requirements see them; a `Watcher` (see `execution.execution_feature`).

    Args:
        stop_at: the number of the event at which `stop` is called; 0: at none.
        stop: is called with signals and messages up to then.
    """

    stop_at: int = 0
    stop: Callable[[Mapping[str, Value], Mapping[str, Mapping[str, Value]]], None] = lambda signals, messages: None
    times_s: list[float] = field(default_factory=list)
    _signals: dict[str, Value] = field(default_factory=dict)
    _messages: dict[str, Mapping[str, Value]] = field(default_factory=dict)

    def message(self, time_s: float, topic: str, fields: Mapping[str, Value]) -> None:
        """A message arrived."""
        self._messages[topic] = dict(fields)
        self._count(time_s)

    def signal(self, time_s: float, name: str, value: Value) -> None:
        """A signal changed."""
        self._signals[name] = value
        self._count(time_s)

    def _count(self, time_s: float) -> None:
        self.times_s.append(time_s)
        if len(self.times_s) == self.stop_at:
            self.stop(self._signals, self._messages)

    def last_until(self, time_s: float) -> int:
        """The number of the last event up to this time (s)."""
        return max((number for number, at_s in enumerate(self.times_s, 1) if at_s <= time_s), default=1)


def first_violation(result: CaseResult, asked: Sequence[str]) -> tuple[str, float] | None:
    """The requirement that a run violated first, of those asked for, and when (s); None if it violated none."""
    violated = [
        (violation.time_s, verdict.requirement)
        for verdict in result.verdicts
        if verdict.requirement in asked
        for violation in verdict.violations
    ]
    return (min(violated)[1], min(violated)[0]) if violated else None


@dataclass
class BreakpointRunner:
    """Runs tests, and stops where they violate what was asked for.

    Args:
        asked: requirements.
        settings: what runs are judged and measured with.
        files: the files of the code under test.
    """

    asked: Sequence[str]
    settings: RunSettings
    files: Sequence[Path]
    _quit: BaseException | None = field(default=None, init=False)
    """The exception of quitting the debugger: not raised where it stops, as it would look like an error of the code."""

    def run(self, test: ConcreteTest) -> CaseResult:
        """Run a test; where it violates a requirement, once more, to stop there. Returns the first run's result."""
        counting = EventCounter()
        result = execute(self.settings, test, NAME, watching=[counting])
        first = first_violation(result, self.asked)
        if first is None:
            return result
        code: list[CodeUnderTest] = []

        def stop(signals: Mapping[str, Value], messages: Mapping[str, Mapping[str, Value]]) -> None:
            self._stop(self._now(first, result, signals, messages, code[0]), code[0])

        stopping = EventCounter(counting.last_until(first[1]), stop)
        try:
            execute(self.settings, test, NAME, watching=[stopping], begun=code.append)
        finally:
            vars(builtins).pop(NAME, None)
        if self._quit is not None:
            raise self._quit
        return result

    def _now(
        self,
        first: tuple[str, float],
        result: CaseResult,
        signals: Mapping[str, Value],
        messages: Mapping[str, Mapping[str, Value]],
        code: CodeUnderTest,
    ) -> Now:
        topic, _, name = self.settings.testbench.state.name.partition(".")
        return Now(
            requirement=first[0],
            time_s=first[1],
            signals=dict(signals),
            messages=dict(messages),
            state=str(messages.get(topic, {}).get(name, "")),
            verdicts={verdict.requirement: verdict.verdict for verdict in result.verdicts},
            nodes=tuple(code.wait_frames),
        )

    def _stop(self, now: Now, code: CodeUnderTest) -> None:
        """Give the instant to a debugger: the attached one, or pdb at the terminal."""
        setattr(builtins, NAME, now)
        here = sys._getframe()
        if debugger():
            _stop_in_ide(_find_project_frame(here))
            return
        try:
            frames = [_find_code_frame(frame, self.files) for frame in (here, *code.wait_frames.values())]
            pdb = pytestPDB._init_pdb("hri-break-on-violation", header=_header(now))  # type: ignore[no-untyped-call]
            pdb.reset()
            pdb.interaction(next((frame for frame in frames if frame is not None), here), None)
        except pytest.exit.Exception as error:
            self._quit = error


def _stop_in_ide(frame: FrameType | None) -> None:
    """Let the attached debugger stop: pydevd (VS Code, PyCharm) in this frame, as soon as control is back there.

    That is at once, before time advances: events are delivered synchronously. It would not stop in a frame of this
    module where the IDE shows only its user's own code, since for it this is a library.
    """
    pydevd = sys.modules.get("pydevd")
    if pydevd is None or frame is None:
        breakpoint()  # the code under test is up the stack
    else:
        pydevd.settrace(suspend=True, trace_only_current_thread=True, patch_multiprocessing=False, stop_at_frame=frame)


def _find_project_frame(frame: FrameType | None) -> FrameType | None:
    """The innermost frame, from a frame on, that is of the user's project: not of this package."""
    while frame is not None and Path(frame.f_code.co_filename).is_relative_to(_PACKAGE):
        frame = frame.f_back
    return frame


def _find_code_frame(frame: FrameType | None, files: Sequence[Path]) -> FrameType | None:
    """The innermost frame of the code under test, from a frame on."""
    names = {str(path) for path in files}
    while frame is not None and frame.f_code.co_filename not in names:
        frame = frame.f_back
    return frame


def _header(now: Now) -> str:
    return f"{now.requirement} is violated at {seconds(now.time_s)}: see {NAME}; c continues, q ends the session"
