"""The closing loop in a session (`--hri-close`): its options, and the suite that it adds to the others.

`ClosingFeature` is the `FEATURE` of this folder (see `registry`). Its method `generate` returns the suite `closure`,
made by `ClosureGenerator`, before the session's tests run.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from pytest_hricdv.extra.closing.records import CLOSING, ClosingOptions
from pytest_hricdv.session.feature import Feature
from pytest_hricdv.session.option import Flag, OptionReader, Value, usage_error

if TYPE_CHECKING:
    from pytest_hricdv.results.model import Report
    from pytest_hricdv.results.report_builder import GeneratedSuite
    from pytest_hricdv.session.run_context import RunContext


def merge(reports: Sequence[Report], merged: Report) -> Report:
    """The merged report with the result of the loop, if all reports have the same one."""
    first, *others = (CLOSING.of(report) for report in reports)
    return CLOSING.put(merged, first) if all(other == first for other in others) else merged


NAME = "closure"
"""The name of the method, and of its suite."""


class ClosingFeature(Feature[ClosingOptions]):
    """Generates tests while it runs them, until nothing is open."""

    name = "closing"
    suites = (NAME,)
    options = (
        Flag("close", "after the suites, generate the suite closure, which covers what they leave open", key=False),
        Value("close-runs", "N", f"closure: end the closing loop after N runs (default {ClosingOptions.runs})"),
        Value(
            "close-seconds",
            "S",
            f"closure: end the closing loop after S seconds, whatever is open (default {ClosingOptions.seconds})",
        ),
        Value(
            "close-search",
            "N",
            "closure: of the runs that are left, search in N for violations where margins are smallest "
            "(default: a tenth of the runs made; 0: none)",
        ),
        Value("close-without", "STRATEGY[,...]", "closure: leave these strategies out, to see what they contribute"),
    )

    def asks_for_suites(self, reader: OptionReader) -> bool:
        """`--hri-close` does."""
        return bool(reader.command_line_value("close"))

    def read(self, reader: OptionReader) -> ClosingOptions:
        """Whether there is a loop, and its budget. Raises pytest.UsageError for a sampling that it does not use."""
        named = [] if reader.command_line_value("replay") else _names(reader.text("suite"))
        close = self.asks_for_suites(reader) and not reader.command_line_value("replay")
        options = ClosingOptions(
            asked=close or NAME in named,
            given=close and any(name != NAME for name in named),
            runs=reader.integer("close_runs", ClosingOptions.runs, minimum=1),
            search=reader.integer("close_search", None, minimum=0),
            seconds=reader.integer("close_seconds", ClosingOptions.seconds, minimum=1),
            without=tuple(_names(reader.text("close_without"))),
        )
        if options.asked and reader.text("sampling") not in ("", "uniform"):
            raise usage_error(f"--hri-sampling and the suite {NAME}: the closing loop chooses parameters itself")
        return options

    def rerun_options(self, reader: OptionReader) -> Iterator[str]:
        """The budget, and the strategies left out."""
        if reader.command_line_value("close"):
            yield "--hri-close"
        for name in ("runs", "search", "without"):
            value = reader.command_line_value(f"close_{name}")
            if value is not None:
                yield f"--hri-close-{name}={value}"

    def generate(self, context: RunContext, suites: Sequence[GeneratedSuite]) -> Iterator[GeneratedSuite]:
        """The suite `closure`, where it is asked for."""
        if self.settings(context.options).asked:
            from pytest_hricdv.extra.closing.closing import ClosureGenerator

            yield ClosureGenerator(context.collection, context, self.settings(context.options)).suite(suites)


def _names(text: str) -> list[str]:
    return [name for name in (part.strip() for part in text.split(",")) if name]


FEATURE = ClosingFeature()
