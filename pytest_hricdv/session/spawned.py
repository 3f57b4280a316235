"""The process in which `--hri-isolate` runs one test on systems without forks; `session.isolation` starts it."""

from __future__ import annotations

import base64
import os
import pickle
import warnings
from collections.abc import Callable, Iterator
from typing import IO, NoReturn

import pytest

from pytest_hricdv.session.child_process import END, FreshPytest, FreshSession, disable_core_dumps, serve
from pytest_hricdv.session.isolation import CallResult, answer_of


class SpawnedTest(FreshPytest):
    """Runs the test with its fixtures, and answers with the result of its call."""

    def __init__(self, start: FreshSession, messages: IO[bytes], write: Callable[[bytes], None]) -> None:
        super().__init__(start, write)
        self.options = {"hri_resume": False}
        self._answer = CallResult(problem="its call was not made")
        self._caught: list[warnings.WarningMessage] = []

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> NoReturn:
        """Takes the place of pytest's loop."""
        disable_core_dumps()
        items = [item for item in session.items if item.nodeid in self.start.nodeids]
        try:
            for item in items:
                item.config.hook.pytest_runtest_protocol(item=item, nextitem=None)
        except pytest.exit.Exception as ended:
            self._answer = CallResult(exit=(ended.msg, ended.returncode))
        except BaseException as error:
            self._answer = CallResult(problem=f"{type(error).__name__}: {error}")
        answer = self._answer if items else CallResult(problem="it is not collected there")
        self.write(base64.b64encode(pickle.dumps(answer)))
        self.write(END)
        os._exit(0)

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_call(self) -> Iterator[None]:
        """Keeps the warnings."""
        with warnings.catch_warnings(record=True) as self._caught:
            return (yield)

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_makereport(self, item: pytest.Item) -> Iterator[None]:
        """Keeps the report of the call; fixtures that fail only here are a problem."""
        report: pytest.TestReport = yield  # type: ignore[assignment]
        if report.when == "call":
            self._answer = answer_of(item, report, self._caught)
        elif not report.passed:
            reason = report.longreprtext or str(report.longrepr)
            self._answer = CallResult(problem=f"{report.when} of its fixtures: {reason}")
        return report  # type: ignore[return-value]


if __name__ == "__main__":
    serve(SpawnedTest)
