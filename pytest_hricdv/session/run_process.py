"""A process that runs tests for a campaign or a search, one after the other, and sends each result as soon as known.

It gets `SessionArguments`, then any number of `RunBatch`es, and answers each `RunRequest` with a `RunReply`.
"""

from __future__ import annotations

import contextlib
import importlib
import io
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import msgspec

from pytest_hricdv._base.error_text import error_text
from pytest_hricdv.execution.case import CaseResult, execute
from pytest_hricdv.execution.hri_case import HriCase
from pytest_hricdv.execution.judge import judge_run
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.report import explanation
from pytest_hricdv.results.codec import encode
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.results.report_builder import PytestOutcome, build_result
from pytest_hricdv.session.child_process import (
    END,
    NO_REWRITE_WARNING,
    channel,
    disable_core_dumps,
    preload,
    run_configured,
    send_identity,
)
from pytest_hricdv.session.run_context import RunContext
from pytest_hricdv.session.running import why_unmeasured


@dataclass(frozen=True)
class SessionArguments:
    """The first line that the process receives: the arguments of pytest."""

    arguments: tuple[str, ...]


class RunRequest(msgspec.Struct, frozen=True):
    """A run to execute: its key, suite, pytest item and abstract test, and the seed of the suite."""

    key: tuple[int, int]
    suite: str
    suite_seed: int
    nodeid: str
    data: dict[str, Any]


class RunBatch(msgspec.Struct, frozen=True):
    """Any later line: runs to execute, in order."""

    requests: tuple[RunRequest, ...]


class RunReply(msgspec.Struct, frozen=True):
    """The result of a run.

    Args:
        result: as a report has it.
        replay: the text of its replay file, where it failed.
    """

    key: tuple[int, int]
    result: TestResult
    replay: str = ""


def _serve(context: RunContext, messages: Iterable[bytes], write: Callable[[bytes], None]) -> None:
    disable_core_dumps()
    testbench = context.collection.testbench
    for name in testbench.simulation.requires:
        importlib.import_module(name)
    send_identity(context, write)
    for line in messages:
        batch = msgspec.json.decode(line, type=RunBatch)
        for request in batch.requests:
            write(encode(_reply(context, request)).encode())
        write(END)


def _reply(context: RunContext, request: RunRequest) -> RunReply:
    commands, sampling = context.collection.testbench.commands, context.options.sampling
    case = HriCase(request.suite, AbstractTest.from_data(request.data), commands, sampling)
    result, failure = _execute(context, case, request.nodeid)
    built = _build(context, case, request, result, failure)
    replay = context.provenance.replay(case, built, request.suite_seed).to_json() if built.leaves_evidence else ""
    return RunReply(request.key, built, replay)


def _execute(context: RunContext, case: HriCase, nodeid: str) -> tuple[CaseResult | None, str]:
    """The run, and why there is none."""
    settings = context.run_settings.with_measurement(context.measurement)
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            return execute(settings, case.concrete, f"hricdv|{nodeid}"), ""
    except Exception as error:
        cause = error.__cause__ or error
        return None, error_text(cause)


def _build(
    context: RunContext, case: HriCase, request: RunRequest, result: CaseResult | None, failure: str
) -> TestResult:
    judgement = judge_run(result, context.violation_exemptions)
    ending = PytestOutcome(outcome=judgement.outcome, wall_s=0.0, failure=failure or judgement.reason)
    built = build_result(
        case,
        request.nodeid,
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
        known_violations=context.violation_exemptions,
        units=context.collection.testbench.units,
        seed=request.suite_seed,
        suite=context.options.suites,
        rerun_options=context.options.again,
    )
    return msgspec.structs.replace(built, failure=text)


def main() -> None:
    """Serve: the first line of standard input is `SessionArguments`, the others are batches."""
    preload()
    with channel() as (messages, write):
        start = msgspec.json.decode(messages.readline(), type=SessionArguments)
        status = run_configured(
            (*start.arguments, *NO_REWRITE_WARNING), lambda context: _serve(context, messages, write)
        )
    sys.exit(status or 1)


if __name__ == "__main__":
    main()
