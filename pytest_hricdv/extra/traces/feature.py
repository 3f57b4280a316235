"""`TracesFeature` writes runs as MCAP files (`--hri-mcap`), which viewers such as Foxglove open; the report links them.

Without the option, failing tests of ROS 2 nodes still get a *bag*: an MCAP file with the ROS 2 messages only.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib.util import find_spec
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

import pytest
from msgspec import to_builtins

from pytest_hricdv.extra.traces.records import TRACE
from pytest_hricdv.report.view import View
from pytest_hricdv.session.feature import Feature
from pytest_hricdv.session.option import Flag, HasFeatures, OptionReader, usage_error

if TYPE_CHECKING:
    from pytest_hricdv.execution.hri_case import HriCase
    from pytest_hricdv.extra.traces.trace_writer import TraceWriter
    from pytest_hricdv.report.formatting import Line
    from pytest_hricdv.results.model import Report, TestResult
    from pytest_hricdv.session.run_context import RunContext

Traced = Literal["", "bags", "failing", "all"]
"""Which tests get a file: all, those that fail, or those that fail with a bag only (`bags`); empty: none."""

_WRITER: pytest.StashKey[TraceWriter] = pytest.StashKey()


class TracesFeature(Feature[Traced]):
    """Writes runs as MCAP files into the folder of the report."""

    name = "traces"
    group = "files"
    options = (
        Flag("mcap", "write the runs of failing tests as MCAP files, which Foxglove and other viewers open"),
        Flag("mcap-all", "write the runs of all tests as MCAP files"),
    )

    switched_off = MappingProxyType({"hri_mcap": False, "hri_mcap_all": False})

    def read(self, reader: OptionReader) -> Traced:
        """Which runs are written."""
        if reader.flag("mcap_all"):
            return "all"
        if reader.flag("mcap"):
            return "failing"
        return "" if reader.command_line_value("mcap") is False else "bags"  # False: see `switched_off`

    def fingerprint(self, options: HasFeatures) -> Mapping[str, str]:
        """A result names its files."""
        return {"--hri-mcap": self.settings(options)}

    def check(self, context: RunContext) -> None:
        """Whether the files can be written."""
        if self.settings(context.options) in ("failing", "all") and find_spec("mcap") is None:
            raise usage_error('--hri-mcap: mcap is not installed: pip install "pytest-hricdv[traces]"')

    def after_test(
        self, context: RunContext, case: HriCase, result: TestResult, report: pytest.TestReport
    ) -> TestResult:
        """The result with its MCAP file, if there is to be one."""
        traced = self.settings(context.options)
        if case.result is None or not (traced == "all" or (traced and result.leaves_evidence)):
            return result
        if traced == "bags" and (context.collection.testbench.ros2 is None or find_spec("mcap") is None):
            return result
        from pytest_hricdv.extra.traces.trace_writer import TraceWriter

        writer = context.stash.setdefault(_WRITER, TraceWriter(context.run_settings, context.options.report))
        if traced == "bags":
            bag = writer.bag(case.result, result)
            return result if bag is None else TRACE.put(result, bag)
        return TRACE.put(result, writer.trace(case.result, result))


FEATURE = TracesFeature()


class TracesView(View):
    """The view of traces: the number of files, and on a test's page its own file."""

    name = "traces"
    scripts = ("trace",)

    def file_lines(self, report: Report, columns: int) -> Iterator[Line]:
        """The number of written runs, and why others were not written."""
        from pytest_hricdv.report.formatting import Line, count_notes, plural

        traces = [trace for test in report.tests if (trace := TRACE.of(test)) is not None]
        if not traces:
            return
        written = sum((trace.file or trace.bag) is not None for trace in traces)
        if not any(trace.file for trace in traces) and written:
            yield Line(f"bags of ROS 2: of {plural(written, 'test')} that failed, next to the report")
            return
        text = f"traces: {written} of {plural(len(traces), 'test')}, next to the report"
        yield Line(text, "ok" if written else "warn")
        yield from count_notes((trace.note for trace in traces), columns)

    def of_test(self, report: Report, test: TestResult) -> dict[str, Any]:
        """Its files."""
        return {"trace": to_builtins(TRACE.of(test))}


VIEW = TracesView()
