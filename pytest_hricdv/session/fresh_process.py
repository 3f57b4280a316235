"""A fresh process: pytest as in a worker of xdist, with some tests of the session, in the order in which they are sent.

It generates nothing, and writes no report. The audit runs tests again there, and isolation runs each test there where
this system has no forks. What is done with the tests, a plugin says that is a `FreshPytest`.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import IO, Any, NoReturn

import msgspec
import pytest

from pytest_hricdv.session.collection import ALONE
from pytest_hricdv.session.serving import preload, session

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
        handed = self.start.handed | ({} if hasattr(os, "fork") else {ALONE: True})
        setattr(config, "workerinput", handed)  # noqa: B010  as xdist does
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


def handed(config: pytest.Config, ours: Mapping[str, object]) -> dict[str, Any]:
    """What a worker is handed: ours, and what plugins look for in it.

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
