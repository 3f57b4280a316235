"""Suggestions in a session: its options, and what it does after the last test."""

from __future__ import annotations

import os
from types import MappingProxyType
from typing import TYPE_CHECKING

from pytest_hricdv.extra.suggestion.options import SuggestionOptions
from pytest_hricdv.session.feature import Feature, FeatureSession
from pytest_hricdv.session.option import Flag, OptionReader, Value, usage_error

if TYPE_CHECKING:
    from pytest_hricdv.results.model import Report
    from pytest_hricdv.session.run_context import RunContext


class SuggestionFeature(Feature[SuggestionOptions]):
    """Suggests requirements that all runs satisfied."""

    name = "suggestion"
    options = (
        Flag(
            "suggest",
            "after all tests, suggest requirements that all of their runs satisfied, those first that notice the most "
            "seeded faults which no requirement notices",
            shown=False,  # `hricdv suggest` has it
        ),
        Value("suggest-most", "N", f"suggest at most N requirements (default {SuggestionOptions.most})"),
        Value(
            "suggest-faults",
            "N",
            f"rank suggestions by N seeded faults, drawn with the seed; 0: none (default {SuggestionOptions.faults})",
        ),
        Value(
            "suggest-further",
            "N",
            "before a suggestion is shown, try to refute it with N further tests (default "
            f"{SuggestionOptions.further})",
        ),
        Value("suggest-seconds", "S", "start no new fault after S seconds (default: no limit)"),
        Flag("suggest-anew", "ignore existing requirements, to compare suggestions with them"),
    )

    switched_off = MappingProxyType({"hri_suggest": False})

    def read(self, reader: OptionReader) -> SuggestionOptions:
        """How requirements are suggested. Raises pytest.UsageError for options that contradict each other."""
        options = SuggestionOptions(
            asked=reader.flag("suggest"),
            most=reader.integer("suggest_most", SuggestionOptions.most, minimum=1),
            faults=reader.integer("suggest_faults", SuggestionOptions.faults, minimum=0),
            further=reader.integer("suggest_further", SuggestionOptions.further, minimum=0),
            seconds=reader.integer("suggest_seconds", None, minimum=1),
            anew=reader.flag("suggest_anew"),
        )
        if options.asked and reader.command_line_value("shard") is not None:
            raise usage_error("--hri-suggest and --hri-shard: give one of them; suggestions rest on whole suites")
        if reader.command_line_value("suggest") and not reader.text("suite"):
            raise usage_error("--hri-suggest: expected a suite to learn of, as --hri-suite=rl (suggest --suite=rl)")
        return options

    def check(self, context: RunContext) -> None:
        """Whether runs can be recorded on this system."""
        if self.settings(context.options).asked and not hasattr(os, "fork"):
            raise usage_error("--hri-suggest: this system cannot fork processes; use Linux or macOS")

    def follow_up(self, context: RunContext) -> str:
        """Suggestions, where they are asked for."""
        return "suggestions (--hri-suggest)" if self.settings(context.options).asked else ""

    def extend_report(self, session: FeatureSession, report: Report) -> Report:
        """The report with the suggestions, if asked for."""
        settings = self.settings(session.options)
        if session.interrupted or not settings.asked:
            return report
        from pytest_hricdv.extra.suggestion.suggest import suggest  # few sessions need it

        report = suggest(session, report, settings)
        session.done.update(() if session.interrupted else [self.name])
        return report


FEATURE = SuggestionFeature()
"""How requirements are suggested."""
