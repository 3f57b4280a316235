"""The server side of a subprocess that runs tests for a session, most of them in forks (see `separate_process`).

pytest is configured in it as in the session, so that conftest files, the testbench and the world are what they are
there. What is sent to it and what it answers are lines of JSON.
"""

from __future__ import annotations

import importlib
import math
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, NoReturn

import msgspec
import pytest

from pytest_hricdv._base.project_files import identity
from pytest_hricdv.execution.execution_feature import execution_features
from pytest_hricdv.session.collection import ALONE

try:
    import resource
except ImportError:
    resource = None  # type: ignore[assignment]  # not on Windows, where a run that does not end is not ended

if TYPE_CHECKING:
    from pytest_hricdv.session.run_context import RunContext

PRELOADED = (
    "pytest_hricdv.monitor.pattern_parser",
    *(f"pytest_hricdv.session.{name}" for name in ("aggregation", "exports", "preparation", "progress", "reporting")),
)
"""Modules that the plugin imports when pytest is configured: imported once here, not again in each fork. They are named
because the module that starts this process is among them."""


UNWARNED = ("-W", "ignore::pytest.PytestAssertRewriteWarning")
"""The modules of the plugin are imported before pytest can rewrite their asserts."""

END = b""
"""The line that ends the answer to a message."""


def arguments_of(config: pytest.Config) -> tuple[str, ...]:
    """The arguments of the session."""
    unmeasured = ["--no-cov"] if hasattr(config.option, "no_cov") else []  # of pytest-cov
    arguments = map(os.fspath, config.invocation_params.args)
    return (*arguments, *unmeasured, *UNWARNED)


@contextmanager
def session() -> Iterator[tuple[IO[bytes], Callable[[bytes], None]]]:
    """Within the process: the lines that the session sends, and what sends it a line.

    pytest replaces standard input and output when it is configured. What anybody else prints goes nowhere.
    """
    with os.fdopen(os.dup(0), "rb") as messages, os.fdopen(os.dup(1), "wb") as output:
        silence(1)

        def write(line: bytes) -> None:
            output.write(line + b"\n")
            output.flush()

        yield messages, write


def preload() -> None:
    """Import what configuring pytest will import."""
    for name in (*PRELOADED, *(module for feature in execution_features() for module in feature.preloaded)):
        importlib.import_module(name)


def in_session(arguments: tuple[str, ...], work: Callable[[RunContext], None]) -> int:
    """Configure pytest as in the session, do the work, and end the process. Returns pytest's status where it could not.

    pytest's own end is left out: it takes longer than some tests.
    """
    return int(pytest.main([*arguments], plugins=[_Instead(work)]))


def introduce(context: RunContext, write: Callable[[bytes], None]) -> None:
    """Answer the first message: what is installed here, and of which project."""
    root = Path(context.collection.config.rootpath)
    write(msgspec.json.encode(identity(root, context.provenance.code)))
    write(END)


class _Instead:
    """A plugin of pytest that does something else than a session."""

    def __init__(self, work: Callable[[RunContext], None]) -> None:
        self._work = work

    def pytest_cmdline_main(self, config: pytest.Config) -> NoReturn:
        """Does the work in place of the session."""
        from pytest_hricdv.session.run_context import CONTEXT

        config._do_configure()  # as pytest's own --help does: the testbench may need what conftest files set up
        context = config.stash[CONTEXT]  # the session has a suite
        _ = context.run_settings
        self._work(context)
        os._exit(0)


RUN_S = 60.0
"""Processor time (s) after which a run is ended: some sixty times that of a run of the table (docs/studies/closure.md:
288 runs in 2.4 minutes on two cores)."""


def limit_time(run_s: float) -> None:
    """The kernel ends this process when it takes more processor time from now on (s), whatever it does.

    Without effect on Windows, and where runs do not begin in forks: there it would end them all.
    """
    if resource is None or not hasattr(os, "fork"):
        return
    used = resource.getrusage(resource.RUSAGE_SELF)
    _, hard = resource.getrlimit(resource.RLIMIT_CPU)
    resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(used.ru_utime + used.ru_stime + run_s), hard))


def leave_no_core() -> None:
    """A process that the kernel ends writes no file about it."""
    if resource is not None:
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def silence(descriptor: int) -> None:
    """Discard whatever is written to the descriptor."""
    with open(os.devnull, "wb") as nowhere:
        os.dup2(nowhere.fileno(), descriptor)


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
    "allure_report_dir": None,
    "log_file": os.devnull,
}
"""Options that select tests, or write files that are the session's."""

_EDITOR = "vscode_pytest"


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


_RERUNNING = ("rerunfailures",)
"""Plugins that run a failing test again until it passes: here a test runs once, and they ask for a server that only the
controller of a session with workers has."""


class FreshPytest:
    """Configures pytest; a plugin of the pytest that is started in the process. Others do something with the tests.

    Args:
        start: what the process was sent first.
        write: answers a line.
    """

    options: Mapping[str, object] = {}
    """Further options, by their destination, which differ from the session's."""

    def __init__(self, start: FreshSession, write: Callable[[bytes], None]) -> None:
        self.start = start
        self.write = write

    @pytest.hookimpl(tryfirst=True)
    def pytest_cmdline_main(self, config: pytest.Config) -> None:
        """Configures it as a worker, with these tests."""
        options = vars(config.option)
        options.update({name: value for name, value in (_SINGLE | _ALL).items() if name in options})
        options.update(self.options)
        worker_values = self.start.handed | ({} if hasattr(os, "fork") else {ALONE: True})
        setattr(config, "workerinput", worker_values)  # noqa: B010  as xdist does
        config.args = [os.path.join(config.rootpath, nodeid) for nodeid in self.start.nodeids]
        config.args_source = pytest.Config.ArgsSource.ARGS
        for name in _RERUNNING:
            if (plugin := config.pluginmanager.get_plugin(name)) is not None:
                config.pluginmanager.unregister(plugin)


def without_editor(arguments: Sequence[str]) -> tuple[str, ...]:
    """The arguments of a session, without the plugin of VS Code, which would tell the editor of further runs."""
    kept: list[str] = []
    for argument in arguments:
        if argument == _EDITOR and kept and kept[-1] == "-p":
            kept.pop()
        else:
            kept.append(argument)
    return tuple(kept)


def worker_values(config: pytest.Config, ours: Mapping[str, object]) -> dict[str, Any]:
    """The input of a worker: ours, and the entries that plugins look for.

    Args:
        config: of the session.
        ours: of this plugin.
    """
    seed = config.getoption("randomly_seed", None)  # of pytest-randomly
    further = {"randomly_seed": seed} if isinstance(seed, int) else {}
    worker = {"workerid": "gw0", "workercount": 1, "testrunuid": "fresh", "mainargv": list(sys.argv)}
    return {**worker, **further, **ours}


def serve(plugin: Callable[[FreshSession, IO[bytes], Callable[[bytes], None]], FreshPytest]) -> NoReturn:
    """Be a fresh process: the first line of standard input is a `FreshSession`; what comes after it, the plugin reads.

    Args:
        plugin: is made of what was sent first, the lines that follow, and what answers a line.
    """
    preload()
    with session() as (messages, write):
        with open(os.devnull, "rb") as nothing:
            os.dup2(nothing.fileno(), 0)  # a test that reads its input would read what is sent
        start = msgspec.json.decode(messages.readline(), type=FreshSession)
        status = pytest.main([*start.arguments], plugins=[plugin(start, messages, write)])
    sys.exit(int(status) or 1)
