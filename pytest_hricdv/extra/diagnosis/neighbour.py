"""The nearest neighbour that passes, run once more to be shown: of other runs only what is compared is kept."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace

import msgspec

from pytest_hricdv.coverage.code_map import CodeMap
from pytest_hricdv.coverage.own_coverage import debugger
from pytest_hricdv.extra.diagnosis.executed_lines import executed_lines
from pytest_hricdv.extra.diagnosis.records import Neighbour
from pytest_hricdv.extra.diagnosis.runs import in_fork
from pytest_hricdv.extra.diagnosis.tracing import Tracing
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.results.timeline import timeline
from pytest_hricdv.session.replaying import TestRerunner, named

Showing = Callable[[ConcreteTest], Neighbour | None]
"""Runs a test to be shown; None where the run came to no end."""

_DECODER: msgspec.json.Decoder[Neighbour | None] = msgspec.json.Decoder(Neighbour | None)


def showing(rerunning: TestRerunner, code: CodeMap) -> Showing:
    """Runs tests traced, in a fork where there is one, and keeps what the page shows.

    Args:
        rerunning: runs tests.
        code: under test.
    """

    def run_here(test: ConcreteTest) -> Neighbour | None:
        return _neighbour(rerunning, code, named(test, "neighbour"))

    def run(test: ConcreteTest) -> Neighbour | None:
        return _DECODER.decode(in_fork(rerunning, lambda: run_here(test))) if hasattr(os, "fork") else run_here(test)

    return run


def _neighbour(rerunning: TestRerunner, code: CodeMap, test: ConcreteTest) -> Neighbour | None:
    tracing = None if debugger() or not code.files else Tracing(code)
    if tracing is None:
        result = rerunning.run(test)
    else:
        result = replace(rerunning, settings=rerunning.settings.measured_by(tracing)).run(test, tracing.begun)
    if result is None:
        return None
    return Neighbour(
        timeline=timeline(result.record, result.verdicts, result.sim_s),
        abstract=tuple(action.command for action in result.test.actions),
        begun=tuple((round(time_s, 3), number) for time_s, number in zip(result.acted_s, result.begun, strict=True)),
        lines=None if tracing is None else executed_lines(tracing.steps(), None),
    )
