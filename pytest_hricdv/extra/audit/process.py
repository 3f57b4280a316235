"""A fresh process of the audit: some tests of the session run there, in the order that is sent.

Each order runs in a fork of this process, in which no test has run; where there is no fork, this process does one.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterable, Sequence
from typing import NoReturn

import msgspec
import pytest

from pytest_hricdv.execution.forked import Fork, ForkError, InFork, fork
from pytest_hricdv.extra.audit.sources import Reading, SourceWatch
from pytest_hricdv.results.codec import encode
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.session.collection import ATTRIBUTE
from pytest_hricdv.session.serving import END, FreshPytest, FreshSession, leave_no_core, serve


class RerunOrder(msgspec.Struct, frozen=True):
    """A further line: tests to run.

    Args:
        nodeids: in order; the last one is asked about.
        still: kinds of sources that stand still.
        watched: notice what is read.
        hidden: files that are not there.
    """

    nodeids: tuple[str, ...]
    still: tuple[str, ...] = ()
    watched: bool = False
    hidden: tuple[str, ...] = ()


class Ran(msgspec.Struct, frozen=True):
    """What the last test of an order came to.

    Args:
        result: of it; None where it has none.
        readings: what it read, where that was to be noticed.
        problem: why there is no result.
    """

    result: TestResult | None = None
    readings: tuple[Reading, ...] = ()
    problem: str = ""


class _Fresh(FreshPytest):
    """Takes the place of pytest's loop."""

    def __init__(self, start: FreshSession, messages: Iterable[bytes], write: Callable[[bytes], None]) -> None:
        super().__init__(start, write)
        self.options = {  # what would cost time, or change files of the report
            "hri_no_cov": True,
            "hri_film": False,
            "hri_mcap": False,
            "hri_mcap_all": False,
            "hri_resume": False,
            "htmlpath": None,
            "hri_report": os.path.join(tempfile.gettempdir(), f"hri-audit-{os.getpid()}"),
        }
        self._messages = messages
        self._results: dict[str, str] = {}
        self._reasons: dict[str, str] = {}

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> NoReturn:
        """Runs what is asked for, until there is no more."""
        leave_no_core()
        items = {item.nodeid: item for item in session.items}
        self.write(END)  # it is ready
        for line in self._messages:
            order = msgspec.json.decode(line, type=RerunOrder)
            missing = [nodeid for nodeid in order.nodeids if nodeid not in items]
            if missing:
                answer = Ran(problem=f"{missing[0]} is not collected in a fresh process")
                self.write(encode(answer).encode())
            else:
                self.write(self._answer(order, [items[nodeid] for nodeid in order.nodeids]))
            self.write(END)
        os._exit(0)

    def _answer(self, order: RerunOrder, items: Sequence[pytest.Item]) -> bytes:
        if not hasattr(os, "fork"):
            return encode(self._ran(order, items)).encode()
        process = fork()
        if isinstance(process, InFork):
            try:
                text = encode(self._ran(order, items)).encode()
            except BaseException as error:
                text = encode(Ran(problem=f"{type(error).__name__}: {error}")).encode()
            process.send_and_end(text)
        return _message(process)

    def _ran(self, order: RerunOrder, items: Sequence[pytest.Item]) -> Ran:
        root = str(items[-1].config.rootpath)
        with SourceWatch(root, still=order.still, watched=order.watched, hidden=order.hidden) as sources:
            for item, following in zip(items, (*items[1:], None), strict=True):
                item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
        last = items[-1].nodeid
        text = self._results.get(last)
        if text is None:
            return Ran(problem=self._reasons.get(last, "it left no result"), readings=sources.readings())
        return Ran(msgspec.json.decode(text, type=TestResult), sources.readings())

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Takes the result of a test."""
        text = getattr(report, ATTRIBUTE, None)
        if isinstance(text, str):
            self._results[report.nodeid] = text
        elif not report.passed:
            self._reasons[report.nodeid] = report.longreprtext or str(report.longrepr)


def _message(process: Fork) -> bytes:
    try:
        return process.message()
    except ForkError as error:
        return encode(Ran(problem=f"its process {error}")).encode()
    finally:
        process.close()


if __name__ == "__main__":
    serve(_Fresh)
