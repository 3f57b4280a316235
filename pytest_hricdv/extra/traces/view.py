"""What a report says of the MCAP files beside it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from msgspec import to_builtins

from pytest_hricdv.extra.traces.records import TRACE
from pytest_hricdv.report.formatting import Line, counted_notes, plural
from pytest_hricdv.report.view import View
from pytest_hricdv.results.model import Report, TestResult


class TracesView(View):
    """How many files there are, and on a test's page its own."""

    name = "traces"
    scripts = ("trace",)

    def file_lines(self, report: Report, columns: int) -> Iterator[Line]:
        """How many runs were written, and why others were not."""
        traces = [trace for test in report.tests if (trace := TRACE.of(test)) is not None]
        if not traces:
            return
        written = sum(trace.file is not None for trace in traces)
        text = f"traces: {written} of {plural(len(traces), 'test')}, beside the report"
        yield Line(text, "ok" if written else "warn")
        yield from counted_notes((trace.note for trace in traces), columns)

    def of_test(self, report: Report, test: TestResult) -> dict[str, Any]:
        """Its files."""
        return {"trace": to_builtins(TRACE.of(test))}


VIEW = TracesView()
