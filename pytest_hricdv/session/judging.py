"""Judging: holds a session's report against its gates and its baseline."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from functools import cached_property
from typing import Any

import pytest

from pytest_hricdv.closure.closing import Entry
from pytest_hricdv.gates import baseline
from pytest_hricdv.gates.baseline import BaselineError
from pytest_hricdv.gates.gating import Judgement, judge
from pytest_hricdv.session.options import Options


class Judging:
    """Knows the gates of a session.

    Args:
        options: of the session.
        testbench: its name.
    """

    def __init__(self, options: Options, testbench: str) -> None:
        self.options = options
        self._testbench = testbench

    def check(self, requirements: Collection[str]) -> None:
        """Find what is wrong before any test runs.

        Raises:
            pytest.UsageError: an allowance for a requirement that there is not, or a baseline that cannot be read.
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
    def _baseline(self) -> dict[str, Any] | None:
        path = self.options.baseline
        if path is None or (self.options.update_baseline and not path.exists()):
            return None
        try:
            return baseline.read(path, self._testbench)
        except BaselineError as error:
            raise pytest.UsageError(f"--hri-baseline: {error}") from None

    def judge(self, report: Entry, *, whole: bool) -> Judgement:
        """Hold the report of a run that came to its end against gates and baseline; write the baseline if asked to.

        Args:
            whole: all tests of the suites were selected.
        """
        options = self.options
        if not options.update_baseline:
            return judge(report, replace(options.gates, baseline=self._baseline), options.today, whole=whole)
        found = judge(report, options.gates, options.today, whole=whole)
        told = self._update(report, whole=whole)
        return replace(found, failed=(*found.failed, told)) if told else found

    def _update(self, report: Entry, *, whole: bool) -> str:
        """Write the baseline; what kept it from being written, or nothing."""
        path = self.options.baseline
        assert path is not None, "read_options sees to it"
        if not whole or report["not_run"]:
            return f"{path} was not updated: {report['reported']} of its tests ran: run the whole suites"
        try:
            baseline.write(baseline.baseline_of(report, self._baseline), path)
        except BaselineError as error:
            return f"--hri-update-baseline: {error}"
        return ""
