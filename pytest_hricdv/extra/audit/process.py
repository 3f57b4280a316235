"""A fresh process: pytest as in a worker of xdist, with some tests of the session, which run in the order that is sent.

Each order runs in a fork of this process, in which no test has run; where there is no fork, this process does one.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NoReturn

import msgspec
import pytest

from pytest_hricdv.execution.forked import Fork, ForkError, InFork, fork
from pytest_hricdv.extra.audit.sources import Reading, Sources
from pytest_hricdv.results.codec import encode
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.session.collection import ATTRIBUTE
from pytest_hricdv.session.serving import END, leave_no_core, preload, session

_SINGLE: dict[str, object] = {
    "dist": "no",
    "numprocesses": None,
    "maxprocesses": None,
    "tx": [],
    "distload": False,
    "looponfail": False,
    "usepdb": False,
    "trace": False,
    "reruns": None,
}
"""Options of pytest and xdist as the controller of xdist sets them for workers."""

_ALL: dict[str, object] = {
    "keyword": "",
    "markexpr": "",
    "deselect": None,
    "lf": False,
    "failedfirst": False,
    "newfirst": False,
    "stepwise": False,
    "stepwise_skip": False,
    "maxfail": 0,
    "collectonly": False,
    "cacheclear": False,
    "basetemp": None,
    "xmlpath": None,
    "htmlpath": None,
    "allure_report_dir": None,
    "log_file": os.devnull,
}
"""Options that select tests, or write files that are the session's."""

_EDITOR = "vscode_pytest"

_OURS = {"hri_no_cov": True, "hri_film": False, "hri_mcap": False, "hri_mcap_all": False, "hri_resume": False}
"""What would cost time, or change files of the report."""


@dataclass(frozen=True)
class FreshSession:
    """The first line that is sent.

    Args:
        arguments: of pytest, as the session was started with.
        handed: what a worker of xdist is handed: suites, and what plugins need.
        nodeids: the tests that there are.
    """

    arguments: tuple[str, ...]
    handed: dict[str, Any]
    nodeids: tuple[str, ...]


class Order(msgspec.Struct, frozen=True):
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


class _Fresh:
    """Takes the place of pytest's loop; a plugin of the pytest that is started here."""

    def __init__(self, start: FreshSession, messages: Iterable[bytes], write: Callable[[bytes], None]) -> None:
        self._start = start
        self._messages = messages
        self._write = write
        self._results: dict[str, str] = {}
        self._reasons: dict[str, str] = {}

    @pytest.hookimpl(tryfirst=True)
    def pytest_cmdline_main(self, config: pytest.Config) -> None:
        """Configures it as a worker, with these tests."""
        options = vars(config.option)
        options.update({name: value for name, value in (_SINGLE | _ALL).items() if name in options})
        options.update(_OURS, hri_report=os.path.join(tempfile.gettempdir(), f"hri-audit-{os.getpid()}"))
        setattr(config, "workerinput", dict(self._start.handed))  # noqa: B010  as xdist does
        config.args = [os.path.join(config.rootpath, nodeid) for nodeid in self._start.nodeids]
        config.args_source = pytest.Config.ArgsSource.ARGS

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> NoReturn:
        """Runs what is asked for, until there is no more."""
        leave_no_core()
        items = {item.nodeid: item for item in session.items}
        self._write(END)  # it is ready
        for line in self._messages:
            order = msgspec.json.decode(line, type=Order)
            missing = [nodeid for nodeid in order.nodeids if nodeid not in items]
            if missing:
                answer = Ran(problem=f"{missing[0]} is not collected in a fresh process")
                self._write(encode(answer).encode())
            else:
                self._write(self._answer(order, [items[nodeid] for nodeid in order.nodeids]))
            self._write(END)
        os._exit(0)

    def _answer(self, order: Order, items: Sequence[pytest.Item]) -> bytes:
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

    def _ran(self, order: Order, items: Sequence[pytest.Item]) -> Ran:
        root = str(items[-1].config.rootpath)
        with Sources(root, still=order.still, watched=order.watched, hidden=order.hidden) as sources:
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


def without_editor(arguments: Sequence[str]) -> tuple[str, ...]:
    """The arguments of a session, without the plugin of VS Code, which would tell the editor of further runs."""
    kept: list[str] = []
    for argument in arguments:
        if argument == _EDITOR and kept and kept[-1] == "-p":
            kept.pop()
        else:
            kept.append(argument)
    return tuple(kept)


def handed(config: pytest.Config, ours: Mapping[str, object]) -> dict[str, Any]:
    """What a worker is handed: ours, and what plugins look for in it.

    Args:
        config: of the session.
        ours: of this plugin.
    """
    seed = config.getoption("randomly_seed", None)  # of pytest-randomly
    further = {"randomly_seed": seed} if isinstance(seed, int) else {}
    worker = {"workerid": "gw0", "workercount": 1, "testrunuid": "audit", "mainargv": list(sys.argv)}
    return {**worker, **further, **ours}


def main() -> None:
    """Serve: the first line of standard input is `FreshSession`, the others are orders."""
    preload()
    with session() as (messages, write):
        with open(os.devnull, "rb") as nothing:
            os.dup2(nothing.fileno(), 0)  # a test that reads its input would read what is sent
        start = msgspec.json.decode(messages.readline(), type=FreshSession)
        status = pytest.main([*start.arguments], plugins=[_Fresh(start, messages, write)])
    sys.exit(int(status) or 1)


if __name__ == "__main__":
    main()
