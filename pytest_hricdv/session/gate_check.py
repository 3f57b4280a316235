"""Checks the report of a session against its gates and its baseline."""

from __future__ import annotations

from collections.abc import Set
from dataclasses import replace
from functools import cached_property

import pytest

from pytest_hricdv.results.baseline import Baseline, BaselineError, baseline_of, read_baseline, write_baseline
from pytest_hricdv.results.judgement import Judgement, judge
from pytest_hricdv.results.model import Report
from pytest_hricdv.session.collection import Collection


class GateCheck:
    """Checks the gates of a session.

    Args:
        collection: of the session.
    """

    def __init__(self, collection: Collection) -> None:
        self.options = collection.options
        self._collection = collection

    def check(self, requirements: Set[str]) -> None:
        """Find faults before any test runs.

        Raises:
            pytest.UsageError: an exemption for a requirement that does not exist, or a baseline that cannot be read.
        """
        allowed = {"known violation of": {*self.options.known, *self.options.gates.known}}
        allowed["NC is allowed for"] = set(self.options.gates.may_be_nc)
        for what, names in allowed.items():
            for name in sorted(names):
                if name not in requirements:
                    known = ", ".join(sorted(requirements))
                    raise pytest.UsageError(f"{what} {name!r}: no such requirement; there are {known}")
        _ = self._baseline

    @cached_property
    def _baseline(self) -> Baseline | None:
        path = self.options.baseline
        if path is None or (self.options.update_baseline and not path.exists()):
            return None
        try:
            return read_baseline(path, self._collection.testbench.name)
        except BaselineError as error:
            raise pytest.UsageError(f"--hri-baseline: {error}") from None

    def judge(self, report: Report, *, whole: bool) -> Judgement:
        """Check the report of a completed session against gates and baseline; write the baseline if asked to.

        Args:
            whole: all tests of the suites were selected.
        """
        options = self.options
        if not options.update_baseline:
            return judge(report, options.gates, self._baseline, options.today, whole=whole)
        found = judge(report, options.gates, None, options.today, whole=whole)
        problem = self._update(report, whole=whole)
        return replace(found, failed=(*found.failed, problem)) if problem else found

    def _update(self, report: Report, *, whole: bool) -> str:
        """Write the baseline; returns why it was not written, or an empty text."""
        path = self.options.baseline
        assert path is not None, "read_options sees to it"
        if not whole or report.not_run:
            return f"{path} was not updated: {report.reported} of its tests ran: run the whole suites"
        try:
            write_baseline(baseline_of(report, self._baseline), path)
        except BaselineError as error:
            return f"--hri-update-baseline: {error}"
        return ""
