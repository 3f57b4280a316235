"""The process that runs tests for a cluster, one after the other, and answers each result as soon as it is known."""

from __future__ import annotations

import contextlib
import importlib
import io
import json
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import msgspec

from pytest_hricdv.execution.case import CaseResult, HriCase, execute
from pytest_hricdv.execution.judge import judge_run
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.report import explanation
from pytest_hricdv.results.building import Ending, build_result
from pytest_hricdv.results.codec import encode
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.runtime.record import Record
from pytest_hricdv.session.run_context import RunContext
from pytest_hricdv.session.running import why_unmeasured
from pytest_hricdv.session.serving import END, UNWARNED, in_session, introduce, leave_no_core, preload, session


@dataclass(frozen=True)
class Job:
    """The first line that is sent: the arguments of pytest."""

    arguments: tuple[str, ...]


class Order(msgspec.Struct, frozen=True):
    """A run to do: its key, suite, pytest item and abstract test, and the seed that its suite was generated from."""

    key: tuple[int, int]
    suite: str
    suite_seed: int
    nodeid: str
    data: dict[str, Any]


class Task(msgspec.Struct, frozen=True):
    """A further line: runs to do, in order; `records`: tell their records, too."""

    orders: tuple[Order, ...]
    records: bool = False


class RunTold(msgspec.Struct, frozen=True):
    """What became of a run.

    Args:
        result: as a report has it.
        replay: the text of its replay file, where it failed.
        record: its events in the order of time, a line each, where that was asked for.
    """

    key: tuple[int, int]
    result: TestResult
    replay: str = ""
    record: tuple[str, ...] = ()


def _serve(context: RunContext, messages: Iterable[bytes], write: Callable[[bytes], None]) -> None:
    leave_no_core()
    testbench = context.collection.testbench
    for name in testbench.requires:
        importlib.import_module(name)
    introduce(context, write)
    for line in messages:
        task = msgspec.json.decode(line, type=Task)
        for order in task.orders:
            write(encode(_told(context, order, with_record=task.records)).encode())
        write(END)


def _told(context: RunContext, order: Order, *, with_record: bool) -> RunTold:
    commands, sampling = context.collection.testbench.commands, context.options.sampling
    case = HriCase(order.suite, AbstractTest.from_data(order.data), commands, sampling)
    result, failure = _executed(context, case, order.nodeid)
    built = _built(context, case, order, result, failure)
    replay = context.provenance.replay(case, built, order.suite_seed).to_json() if built.leaves_evidence else ""
    record = tuple(events(result.record)) if with_record and result is not None else ()
    return RunTold(order.key, built, replay, record)


def _executed(context: RunContext, case: HriCase, nodeid: str) -> tuple[CaseResult | None, str]:
    """The run, and why there is none."""
    settings = context.run_settings.measured_by(context.measurement)
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            return execute(settings, case.concrete, f"hricdv|{nodeid}"), ""
    except Exception as error:
        cause = error.__cause__ or error
        return None, f"{type(cause).__name__}: {cause}"


def _built(context: RunContext, case: HriCase, order: Order, result: CaseResult | None, failure: str) -> TestResult:
    judgement = judge_run(result, context.known)
    ending = Ending(outcome=judgement.outcome, wall_s=0.0, failure=failure or judgement.reason)
    built = build_result(
        case,
        order.nodeid,
        result,
        code=context.code,
        requirements=context.requirements,
        unmeasured=why_unmeasured(result, context.measurement),
        ending=ending,
    )
    built = msgspec.structs.replace(built, wall_s=None)  # how long it took is no result
    if built.outcome != "failed":
        return built
    text = explanation.failure(
        built,
        context.texts,
        known=context.known,
        units=context.collection.testbench.units,
        seed=order.suite_seed,
        suite=context.options.suites,
        rerun_options=context.options.again,
    )
    return msgspec.structs.replace(built, failure=text)


def events(record: Record) -> Iterator[str]:
    """All that the hash of a record is over, in the order of time, a line each."""
    found: list[tuple[float, str]] = [
        (each.time_s, f"{each.sender} {each.topic} {json.dumps(dict(each.fields), sort_keys=True)}")
        for each in record.messages
    ]
    for name in sorted([*record.signals, *record.texts]):
        times, values = record.signals[name] if name in record.signals else record.texts[name]
        found += [(time_s, f"{name} = {value!r}") for time_s, value in zip(times, values, strict=True)]
    found.sort(key=lambda each: each[0])
    return (f"{time_s!r} s: {text}" for time_s, text in found)


def main() -> None:
    """Serve: the first line of standard input is a `Job`, the others are tasks."""
    preload()
    with session() as (messages, write):
        job = msgspec.json.decode(messages.readline(), type=Job)
        status = in_session((*job.arguments, *UNWARNED), lambda context: _serve(context, messages, write))
    sys.exit(status or 1)


if __name__ == "__main__":
    main()
