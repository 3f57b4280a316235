"""The audit in a session (`--hri-audit`): after the last test, reruns some tests to check that runs repeat.

`AuditFeature` saves environment and import path before the first test. An `Auditor` then reruns each test alone in a
fresh process with both; `AuditView` shows the result.
"""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING

import pytest

from pytest_hricdv.extra.audit.records import AUDIT, UNREPEATABLE, sentence
from pytest_hricdv.report.view import PageSection, View
from pytest_hricdv.session.feature import Feature, FeatureSession
from pytest_hricdv.session.option import OptionReader, Value, usage_error

if TYPE_CHECKING:
    from pytest_hricdv.extra.audit.repeating import Begin
    from pytest_hricdv.results.model import Report, TestResult
    from pytest_hricdv.session.run_context import RunContext

OFF = "off"


@dataclass(frozen=True)
class AuditOptions:
    """Whether tests rerun, and how many; None: as many as take little time."""

    tests: int | None = None
    is_on: bool = True


BEGIN: pytest.StashKey[Begin] = pytest.StashKey()
"""Key of the environment and import path before the first test, in the stash of pytest's configuration."""


class AuditFeature(Feature[AuditOptions]):
    """Reruns some tests, each alone in a fresh process."""

    name = "audit"
    options = (
        Value(
            "audit",
            "N|off",
            "after all tests, rerun N of them, failures first, each alone in a fresh process under another hash seed; "
            "a difference fails the session, and its cause is named (default: 3, or more if they take less than 3 %% "
            "of the time)",
        ),
    )

    def read(self, reader: OptionReader) -> AuditOptions:
        """How many tests run again. Raises pytest.UsageError for what is neither a number nor off."""
        text = reader.text("audit")
        if text == OFF:
            return AuditOptions(is_on=False)
        if text and not (text.isascii() and text.isdigit()):
            raise usage_error(f"{reader.setting('audit')}: expected a whole number, or off")
        return AuditOptions(reader.integer("audit", None, minimum=1))

    def check(self, context: RunContext) -> None:
        """Keep what fresh processes need, before a test can change it."""
        if self.settings(context.options).is_on:
            from pytest_hricdv.extra.audit.repeating import Begin  # it loads what starts processes

            context.stash[BEGIN] = Begin(dict(os.environ), tuple(sys.path))

    def follow_up(self, context: RunContext) -> str:
        """The audit, where it is on."""
        return "the audit" if self.settings(context.options).is_on else ""

    def after_tests(self, session: FeatureSession, results: list[TestResult], *, stopped: bool) -> list[TestResult]:
        """The results, with those marked that gave another result when they reran."""
        settings, context = self.settings(session.options), session.context
        begin = context.stash.get(BEGIN, None)
        if begin is None or stopped or session.interrupted or not results or context.debugger_reason:
            return results
        from pytest_hricdv.extra.audit.auditor import Auditor  # needed after the last test

        return Auditor(session, settings.tests, begin).audit(results)


FEATURE = AuditFeature()


class AuditView(View):
    """The view of the audit: which tests reran, which gave another result, and why."""

    name = "audit"

    def section(self, report: Report) -> PageSection | None:
        """The tests that gave another result, with their causes; in a merged report, of all sessions."""
        from pytest_hricdv.report.formatting import plural

        audit = AUDIT.of(report)
        rows = [(test, UNREPEATABLE.of(test)) for test in report.tests if UNREPEATABLE.of(test) is not None]
        if audit is None and not rows:
            return None
        values = {"audit": audit, "rows": rows}
        template = "audit/audit.html.jinja"
        if not rows:
            return PageSection("repeatability", "", template, values, "in summary")
        headline = f"{plural(len(rows), 'test')} not repeatable"
        return PageSection("repeatability", "Repeatability", template, values, headline=headline)

    def facts(self, test: TestResult) -> dict[str, str]:
        """Why it is not repeatable."""
        record = UNREPEATABLE.of(test)
        return {"Repeatability": "" if record is None else sentence(record)}


VIEW = AuditView()
