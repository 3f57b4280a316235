"""A fresh process in which the audit reruns tests of the session.

`Repeater` starts it, sends a `RerunOrder` for each rerun through a pipe, and gets a `RerunAnswer`. Each order runs in a
fork of its own, in which no test has run before. On a system without forks, the process serves a single request.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterable, Sequence
from typing import NoReturn

import msgspec
import pytest

from pytest_hricdv._base.error_text import text_of
from pytest_hricdv.execution.forks import Fork, ForkError, InFork, fork
from pytest_hricdv.extra.audit.sources import Reading, SourceWatch
from pytest_hricdv.results.codec import encode
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.session.child_process import END, FreshPytest, FreshSession, disable_core_dumps, serve
from pytest_hricdv.session.collection import ATTRIBUTE
from pytest_hricdv.session.option import feature_options


class RerunOrder(msgspec.Struct, frozen=True):
    """A request: tests to run, and how.

    Args:
        nodeids: the node ids of the tests, in order; the result of the last one is sent back.
        still: types of sources, such as clocks, that always give the same value.
        watched: whether to record which sources are read.
        hidden: files that appear to be missing.
    """

    nodeids: tuple[str, ...]
    still: tuple[str, ...] = ()
    watched: bool = False
    hidden: tuple[str, ...] = ()


class RerunAnswer(msgspec.Struct, frozen=True):
    """The answer to a request.

    Args:
        result: the result of the last test; None if it has none.
        readings: the sources that it read, if they were watched.
        problem: why there is no result.
    """

    result: TestResult | None = None
    readings: tuple[Reading, ...] = ()
    problem: str = ""

    @property
    def key(self) -> RunKey:
        """Two runs with the same key are the same."""
        return key_of(self.result) if self.result is not None else (None, self.problem or "error")


RunKey = tuple[str | None, str]
"""Hash of a run's record, and its outcome."""


def key_of(result: TestResult) -> RunKey:
    """See `RunKey`."""
    return result.record_sha256, result.outcome


class _Fresh(FreshPytest):
    """Replaces pytest's loop over tests."""

    def __init__(self, start: FreshSession, messages: Iterable[bytes], write: Callable[[bytes], None]) -> None:
        super().__init__(start, write)
        self.options = {  # without what takes time or changes files of the report
            "hri_no_cov": True,
            "hri_resume": False,
            "hri_fail_under": None,
            "htmlpath": None,
            "hri_report": os.path.join(tempfile.gettempdir(), f"hri-audit-{os.getpid()}"),
            **{name: value for feature in feature_options() for name, value in feature.switched_off.items()},
        }
        self._messages = messages
        self._results: dict[str, str] = {}
        self._reasons: dict[str, str] = {}

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> NoReturn:
        """Serves requests until the pipe is closed."""
        disable_core_dumps()
        items = {item.nodeid: item for item in session.items}
        self.write(END)  # it is ready
        for line in self._messages:
            order = msgspec.json.decode(line, type=RerunOrder)
            missing = [nodeid for nodeid in order.nodeids if nodeid not in items]
            if missing:
                answer = RerunAnswer(problem=f"{missing[0]} is not collected in a fresh process")
                self.write(encode(answer).encode())
            else:
                self.write(self._answer(order, [items[nodeid] for nodeid in order.nodeids]))
            self.write(END)
        os._exit(0)

    def _answer(self, order: RerunOrder, items: Sequence[pytest.Item]) -> bytes:
        if not hasattr(os, "fork"):
            return encode(self._run(order, items)).encode()
        process = fork()
        if isinstance(process, InFork):
            try:
                text = encode(self._run(order, items)).encode()
            except BaseException as error:
                text = encode(RerunAnswer(problem=f"{type(error).__name__}: {text_of(error)}")).encode()
            process.send_and_end(text)
        return _message(process)

    def _run(self, order: RerunOrder, items: Sequence[pytest.Item]) -> RerunAnswer:
        root = str(items[-1].config.rootpath)
        with SourceWatch(root, still=order.still, watched=order.watched, hidden=order.hidden) as sources:
            for item, following in zip(items, (*items[1:], None), strict=True):
                item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
        last = items[-1].nodeid
        text = self._results.get(last)
        if text is None:
            return RerunAnswer(problem=self._reasons.get(last, "it left no result"), readings=sources.readings())
        return RerunAnswer(msgspec.json.decode(text, type=TestResult), sources.readings())

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Keeps the result of a test."""
        text = getattr(report, ATTRIBUTE, None)
        if isinstance(text, str):
            self._results[report.nodeid] = text
        elif not report.passed:
            self._reasons[report.nodeid] = report.longreprtext or str(report.longrepr)


def _message(process: Fork) -> bytes:
    try:
        return process.message()
    except ForkError as error:
        return encode(RerunAnswer(problem=f"its process {error}")).encode()
    finally:
        process.close()


if __name__ == "__main__":
    serve(_Fresh)
