"""The same error in many tests: pytest's terminal shows its traceback once, and names the other tests.

A fault of the code under test or of the testbench ends a whole suite with one traceback per test. Violations of
requirements are not folded: each has its own story. Reports stay as they are for everybody else, as JUnit XML and IDEs.
"""

from __future__ import annotations

import re
from typing import Any

import pytest

from pytest_hricdv._base.message import visible
from pytest_hricdv.report.formatting import plural
from pytest_hricdv.session.aggregation import Aggregation

MAX_NAMED = 20
"""Of the tests with the same error (chosen): a few lines of a terminal; -rf lists all."""

ALL_FROM_VERBOSITY = 2
"""With -vv, each test has its traceback."""

_NUMBER = re.compile(r"\d+(?:\.\d+)?")
_VIOLATED = re.compile(r"^(?:E +)?(?P<name>\S+) Failed(?=[:\n]|$)", re.MULTILINE)
VIOLATION = re.compile(r"^\S+ failed at ")
"""The first line of the text of a test that violated a requirement."""

Key = tuple[object, ...]


class RepeatedErrors:
    """Folds what the terminal shows of failures."""

    def __init__(self, aggregation: Aggregation) -> None:
        self._aggregation = aggregation

    def fold(self, terminalreporter: pytest.TerminalReporter, kind: str) -> None:
        """Leave out what repeats an error, of the reports of a kind that are to be shown."""
        if terminalreporter.config.get_verbosity() >= ALL_FROM_VERBOSITY:
            return
        reports = terminalreporter.stats.get(kind, [])
        shown: list[Any] = []
        repeats: dict[Key, tuple[Any, list[str]]] = {}
        for report in reports:
            key = self._key(report)
            if key is None or key not in repeats:
                shown.append(report)
            else:
                repeats[key][1].append(report.nodeid)
            if key is not None:
                repeats.setdefault(key, (report, []))
        if len(shown) == len(reports):
            return
        terminalreporter.stats[kind] = shown
        for report, others in repeats.values():
            if others:
                _add(report, others)

    def _key(self, report: Any) -> Key | None:
        """The same for the same error, wherever numbers differ; None for what is shown in any case."""
        crash = getattr(getattr(report, "longrepr", None), "reprcrash", None)
        if getattr(report, "nodeid", None) not in self._aggregation.chosen or crash is None:
            return None
        first = crash.message.partition("\n")[0]
        if VIOLATION.match(first):
            return None
        violated = tuple(match["name"] for match in _VIOLATED.finditer(report.longreprtext))
        return report.when, crash.path, crash.lineno, _NUMBER.sub("#", first), violated


def _add(report: Any, others: list[str]) -> None:
    title = f"the same in {plural(len(others), 'more test')}"
    named = [visible(nodeid) for nodeid in others[:MAX_NAMED]]
    if len(others) > MAX_NAMED:
        named.append(f"and {len(others) - MAX_NAMED} more")
    report.longrepr.addsection(title, "\n".join(named))
