"""Runs the tests of experiments, each in a fork that may crash or hang, and summarizes each run for the analysis.

`diagnose` makes one `runner`, a function from a test to its `RunSummary`, for all experiments. `in_fork` and `ran` are
its parts, which `pair_search`, `switching` and `executed_lines` use for runs of other kinds.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

import msgspec
from msgspec import Struct

from pytest_hricdv._base.record import Count, Names, Number, PlainRecord
from pytest_hricdv.coverage.code_map import CodeMap
from pytest_hricdv.coverage.measurement import Measurement
from pytest_hricdv.coverage.own_coverage import debugger
from pytest_hricdv.coverage.records import CodeShare
from pytest_hricdv.execution.case import CaseResult, RunSettings
from pytest_hricdv.execution.forks import ForkError, call_in_fork
from pytest_hricdv.execution.run_monitors import formulas
from pytest_hricdv.extra.diagnosis.failures import FAULT
from pytest_hricdv.extra.diagnosis.trace import Tracer, ViolationTrace
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.generate.rng import digest
from pytest_hricdv.monitor import Requirement
from pytest_hricdv.monitor.analysis import names_of, topics_of
from pytest_hricdv.report.formatting import quantity
from pytest_hricdv.session.child_process import RUN_S, limit_processor_time
from pytest_hricdv.session.journaling import JournalKeeper
from pytest_hricdv.session.replaying import TestRerunner, name_test

MAX_EVENTS = 2000
"""Number of first events of a run that are compared. Chosen: a run of the case study has some 300."""


class RunEvent(PlainRecord, frozen=True, kw_only=True):
    """An event of a run, such as a message or a change of a signal.

    Args:
        stream: sender and topic of a message, or the signal.
        value: the fields of a message that are no floats, or the signal's value.
        text: the whole event, for people.
    """

    time_s: Number
    stream: str
    value: str
    text: str


class RunSummary(PlainRecord, frozen=True, kw_only=True):
    """The kept results of a run.

    Args:
        violated: the requirements that it violated, `failures.FAULT` among them.
        outside: those of them with a violation outside the condition under which violations are known.
        checked: the requirements that it passed.
        begun: time (s) and number (from 0) of each action, in the order in which they began.
        events: messages, and changes of signals that are bools or strings, in the order of time.
        times_s: requirement -> when it was violated first.
        traces: requirement that it violated -> what it executed until then; of traced runs only.
        code: what it executed; of measured runs only.
        replay: the file that it was kept in; of minimal tests only.
    """

    violated: Names
    outside: Names = ()
    checked: Names = ()
    begun: tuple[tuple[Number, Count], ...] = ()
    events: tuple[RunEvent, ...] = ()
    times_s: Mapping[str, Number] = {}
    traces: Mapping[str, ViolationTrace] = {}
    code: CodeShare | None = None
    replay: str | None = None


Run = Callable[[ConcreteTest], RunSummary | None]
"""Runs a test; None if the run did not end."""

T = TypeVar("T", bound=Struct)


def runner(rerunner: TestRerunner, code: CodeMap, traced: Mapping[str, ConcreteTest], measurement: Measurement) -> Run:
    """Runs tests in a fork, where there is one: whatever they do to their process, the session's results are safe.

    Args:
        traced: id -> tests whose runs are traced.
        measurement: the measurement of the code, in all other runs.
    """
    measuring = replace(rerunner, settings=rerunner.settings.with_measurement(measurement))

    def run_here(test: ConcreteTest) -> RunSummary | None:
        if traced.get(test.id) == test and not debugger():
            return _trace_run(rerunner, code, name_test(test, "experiment"))
        result = measuring.run(name_test(test, "experiment"))
        return None if result is None else ran(result, rerunner.settings, code.statements)

    return lambda test: in_fork(rerunner, lambda: run_here(test), RunSummary)


def remember_runs(run: Run, journaling: JournalKeeper, part: str) -> Run:
    """Runs that a session which was killed has made before are not made again: they are in its journal.

    Args:
        run: runs a test.
        part: keeps them there under this name.
    """

    def look_up_or_run(test: ConcreteTest) -> RunSummary | None:
        key = digest("run", test.to_json())
        kept = journaling.read_resumed_value(part, key)
        if kept is not None:
            return msgspec.json.decode(kept, type=RunSummary | None)
        result = run(test)
        journaling.keep(part, key, msgspec.json.encode(result))
        return result

    return look_up_or_run


def in_fork(rerunner: TestRerunner, work: Callable[[], T | None], kind: type[T]) -> T | None:
    """The result of a fork, where there are forks; None if it did not end, or took longer than `RUN_S`."""
    if not hasattr(os, "fork"):
        return work()

    def work_in_time() -> bytes:
        limit_processor_time(RUN_S)
        return msgspec.json.encode(work())

    try:
        return msgspec.json.decode(call_in_fork(work_in_time, rerunner.let_through), type=kind | None)
    except ForkError:
        return None


def _trace_run(rerunner: TestRerunner, code: CodeMap, test: ConcreteTest) -> RunSummary | None:
    tracing = Tracer(code)
    settings = rerunner.settings
    result = replace(rerunner, settings=settings.with_measurement(tracing)).run(test, tracing.begin, [tracing])
    if result is None:
        return None
    made = ran(result, settings)
    names = {requirement.id: _names(requirement) for requirement in formulas(settings.requirements)}
    traces = {name: tracing.until(time_s, names.get(name)) for name, time_s in made.times_s.items()}
    if result.errors:  # what is wrong with the whole run
        traces[FAULT] = tracing.until(result.sim_s, None, to_end=True)
    return msgspec.structs.replace(made, traces=traces)


def _names(requirement: Requirement) -> frozenset[str]:
    """The topics and signals that a requirement reads."""
    parts = requirement.formula.conditions
    return frozenset(name for name in names_of(parts) if "." not in name) | topics_of(parts)


def ran(result: CaseResult, settings: RunSettings, statements: int = 0) -> RunSummary:
    """Summarize a run.

    Args:
        settings: the settings that it ran with.
        statements: number of statements of the code under test.
    """
    bools = {name for name, kind in settings.testbench.vocabulary().signals.items() if kind is bool}
    violated = (*result.failed, *((FAULT,) if result.errors else ()))
    times_s = {verdict.requirement: verdict.violations[0].time_s for verdict in result.verdicts if verdict.violations}
    return RunSummary(
        violated=violated,
        outside=tuple(verdict.requirement for verdict in result.verdicts if verdict.outside),
        checked=tuple(verdict.requirement for verdict in result.verdicts if verdict.verdict == "Passed"),
        begun=tuple(zip(result.action_times_s, result.begun, strict=True)),
        events=tuple(sorted(_events(result, bools), key=lambda event: event.time_s))[:MAX_EVENTS],
        times_s=times_s,
        code=None if result.code is None else result.code.share(statements),
    )


def _events(result: CaseResult, bools: Container[str]) -> Iterator[RunEvent]:
    """A message or change of a signal each. Messages come first: of one instant, signals mostly follow from them."""
    for message in result.record.messages:
        if not message.is_disturbance:
            exact = " ".join(
                f"{name}={value}" for name, value in message.fields.items() if not isinstance(value, float)
            )
            shown = " ".join(f"{name}={quantity(value)}" for name, value in message.fields.items())
            stream = f"{message.sender}: {message.topic}"
            yield RunEvent(time_s=message.time_s, stream=stream, value=exact, text=f"{stream} {shown}".rstrip())
    for name, (times_s, texts) in result.record.texts.items():
        yield from _changes(name, times_s, texts)
    for name, (times_s, values) in result.record.signals.items():
        if name in bools:
            yield from _changes(name, times_s, ["true" if value else "false" for value in values])


def _changes(name: str, times_s: Sequence[float], values: Sequence[str]) -> Iterator[RunEvent]:
    for time_s, value in zip(times_s, values, strict=True):
        yield RunEvent(time_s=time_s, stream=name, value=value, text=f"{name} = {value}")
