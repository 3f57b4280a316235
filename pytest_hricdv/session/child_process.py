"""The child side of a subprocess that runs tests for a session (the parent side is `execution.separate_process`).

`run_configured` configures pytest as the session does, so the child has the same conftest files, testbench and world;
`serve` runs some tests of the session in a `FreshPytest`. A child reads requests from standard input and writes answers
to standard output (`channel`). Used by `run_process`, `spawned`, and features such as the audit and mutation testing.
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
    resource = None  # type: ignore[assignment]  # not on Windows: there, a run that does not end is not killed

if TYPE_CHECKING:
    from pytest_hricdv.session.run_context import RunContext

PRELOADED = (
    "pytest_hricdv.monitor.pattern_parser",
    *(f"pytest_hricdv.session.{name}" for name in ("aggregation", "exports", "preparation", "progress", "reporting")),
)
"""Modules that the plugin imports when pytest is configured, imported once here and not in each fork. They are listed
by name, since an import here would be circular."""


NO_REWRITE_WARNING = ("-W", "ignore::pytest.PytestAssertRewriteWarning")
"""Options that silence pytest's warning that modules were imported before it could rewrite their asserts."""

END = b""
"""The empty line that ends an answer."""

RUN_S = 60.0
"""Processor time (s) after which a run is killed: some sixty times that of a run of the table (docs/studies/closure.md:
288 runs in 2.4 minutes on two cores)."""


def session_arguments(config: pytest.Config) -> tuple[str, ...]:
    """The arguments that the session was started with; pytest-cov is switched off."""
    unmeasured = ["--no-cov"] if hasattr(config.option, "no_cov") else []  # of pytest-cov
    arguments = map(os.fspath, config.invocation_params.args)
    return (*arguments, *unmeasured, *NO_REWRITE_WARNING)


@contextmanager
def channel() -> Iterator[tuple[IO[bytes], Callable[[bytes], None]]]:
    """Yield the lines that the session sends, and a function that writes a line to the session.

    Both use copies of the file descriptors, since pytest replaces standard input and output when it is configured.
    Other output of the process is discarded.
    """
    with os.fdopen(os.dup(0), "rb") as messages, os.fdopen(os.dup(1), "wb") as output:
        silence(1)

        def write(line: bytes) -> None:
            output.write(line + b"\n")
            output.flush()

        yield messages, write


def preload() -> None:
    """Import the modules that configuring pytest would import."""
    for name in (*PRELOADED, *(module for feature in execution_features() for module in feature.preloaded)):
        importlib.import_module(name)


def run_configured(arguments: tuple[str, ...], work: Callable[[RunContext], None]) -> int:
    """Configure pytest as in the session, do the work, and exit. Returns pytest's status only if that fails.

    The process exits without pytest's own teardown, which takes longer than some tests.
    """
    return int(pytest.main([*arguments], plugins=[_WorkPlugin(work)]))


def send_identity(context: RunContext, write: Callable[[bytes], None]) -> None:
    """Answer the first message with the installed versions and the hashes of the project's files."""
    root = Path(context.collection.config.rootpath)
    write(msgspec.json.encode(identity(root, context.provenance.code)))
    write(END)


class _WorkPlugin:
    """A pytest plugin that does some work instead of running a session."""

    def __init__(self, work: Callable[[RunContext], None]) -> None:
        self._work = work

    def pytest_cmdline_main(self, config: pytest.Config) -> NoReturn:
        """Do the work instead of running the session."""
        from pytest_hricdv.session.run_context import CONTEXT

        config._do_configure()  # as pytest's own --help does: the testbench may need what conftest files set up
        context = config.stash[CONTEXT]  # the session has a suite
        _ = context.run_settings
        self._work(context)
        os._exit(0)


def limit_processor_time(run_s: float) -> None:
    """Let the operating system kill this process after this much more processor time (s).

    No effect where runs do not have processes of their own (no `fork`, as on Windows): the limit would end all of them.
    """
    if resource is None or not hasattr(os, "fork"):
        return
    used = resource.getrusage(resource.RUSAGE_SELF)
    _, hard = resource.getrlimit(resource.RLIMIT_CPU)
    resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(used.ru_utime + used.ru_stime + run_s), hard))


def disable_core_dumps() -> None:
    """Write no core dump if the operating system kills this process."""
    if resource is not None:
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def silence(descriptor: int) -> None:
    """Discard all output to a file descriptor."""
    with open(os.devnull, "wb") as nowhere:
        os.dup2(nowhere.fileno(), descriptor)


_WORKER_OPTIONS: dict[str, object] = {
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
"""Options of pytest and xdist, with the values that xdist's controller sets for workers."""

_NEUTRAL_OPTIONS: dict[str, object] = {
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
"""Neutral values of options that select tests or write files of the session."""

_EDITOR_PLUGIN = "vscode_pytest"


@dataclass(frozen=True)
class FreshSession:
    """The first message to a fresh process.

    Args:
        arguments: pytest's arguments in the session.
        worker_input: the `workerinput` of an xdist worker: suites, and entries that plugins need.
        nodeids: the tests to collect.
    """

    arguments: tuple[str, ...]
    worker_input: dict[str, Any]
    nodeids: tuple[str, ...]


_RERUN_PLUGINS = ("rerunfailures",)
"""Plugins that rerun failing tests. They are unregistered: a test runs once here, and in workers these plugins need a
server of xdist's controller."""


class FreshPytest:
    """A plugin that configures pytest in a fresh process; subclasses say what to do with the tests.

    Args:
        start: the first message.
        write: writes a line to the session.
    """

    options: Mapping[str, object] = {}
    """Further options (destination -> value) that differ from the session's."""

    def __init__(self, start: FreshSession, write: Callable[[bytes], None]) -> None:
        self.start = start
        self.write = write

    @pytest.hookimpl(tryfirst=True)
    def pytest_cmdline_main(self, config: pytest.Config) -> None:
        """Configure pytest as a worker of xdist that collects the tests of the message."""
        options = vars(config.option)
        options.update({name: value for name, value in (_WORKER_OPTIONS | _NEUTRAL_OPTIONS).items() if name in options})
        options.update(self.options)
        worker_values = self.start.worker_input | ({} if hasattr(os, "fork") else {ALONE: True})
        setattr(config, "workerinput", worker_values)  # noqa: B010  as xdist does
        config.args = [os.path.join(config.rootpath, nodeid) for nodeid in self.start.nodeids]
        config.args_source = pytest.Config.ArgsSource.ARGS
        for name in _RERUN_PLUGINS:
            if (plugin := config.pluginmanager.get_plugin(name)) is not None:
                config.pluginmanager.unregister(plugin)


def drop_editor_plugin(arguments: Sequence[str]) -> tuple[str, ...]:
    """The arguments without VS Code's plugin, which would report these runs to the editor."""
    kept: list[str] = []
    for argument in arguments:
        if argument == _EDITOR_PLUGIN and kept and kept[-1] == "-p":
            kept.pop()
        else:
            kept.append(argument)
    return tuple(kept)


def make_worker_input(config: pytest.Config, ours: Mapping[str, object]) -> dict[str, Any]:
    """The `workerinput` of a worker.

    Args:
        ours: the entries of this plugin; those of xdist and pytest-randomly are added.
    """
    seed = config.getoption("randomly_seed", None)  # of pytest-randomly
    further = {"randomly_seed": seed} if isinstance(seed, int) else {}
    worker = {"workerid": "gw0", "workercount": 1, "testrunuid": "fresh", "mainargv": list(sys.argv)}
    return {**worker, **further, **ours}


def serve(plugin: Callable[[FreshSession, IO[bytes], Callable[[bytes], None]], FreshPytest]) -> NoReturn:
    """Run pytest with a plugin; the first line of standard input is a `FreshSession`.

    Args:
        plugin: makes the plugin from this message, the lines that follow, and the function that writes a line.
    """
    preload()
    with channel() as (messages, write):
        with open(os.devnull, "rb") as nothing:
            os.dup2(nothing.fileno(), 0)  # else a test that reads its input would read the messages
        start = msgspec.json.decode(messages.readline(), type=FreshSession)
        status = pytest.main([*start.arguments], plugins=[plugin(start, messages, write)])
    sys.exit(int(status) or 1)
