"""Suggestions in a session of `hricdv suggest`: `SuggestionFeature` has the options, and calls `suggest` at the end.

`SuggestionView` shows suggested requirements as lines to paste into a requirements file, and as a section of the page.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from types import MappingProxyType
from typing import TYPE_CHECKING

from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.suggestion.options import SuggestionOptions
from pytest_hricdv.extra.suggestion.records import SUGGESTIONS, Suggestion, SuggestionResult
from pytest_hricdv.report.formatting import Line, plural, seconds
from pytest_hricdv.report.view import PageSection, RequirementNote, View
from pytest_hricdv.session.feature import Feature, FeatureSession
from pytest_hricdv.session.option import Flag, OptionReader, Value, usage_error

if TYPE_CHECKING:
    from pytest_hricdv.results.model import Report
    from pytest_hricdv.session.run_context import RunContext


class SuggestionView(View):
    """Suggestions, the most useful first."""

    name = "suggestion"

    def lines(self, report: Report, columns: int) -> Iterator[Line]:
        """Requirements that were suggested and not accepted; what new suggestions rest on."""
        for name, text in report.requirements.items():
            if text.suggested and not text.accepted:
                said = f"{name} was suggested from runs, and nobody has accepted it: add accepted_by and accepted_on"
                yield Line(visible(said), "warn")
        result = SUGGESTIONS.of(report)
        if result is None:
            return
        yield Line(headline(result), "title")
        for ground in grounds(result):
            yield Line(visible(f"  {ground}"))
        for note in result.notes:
            yield Line(visible(f"  {note}"), "warn")

    def findings(self, report: Report) -> Iterator[Line]:
        """The suggestions, to be pasted."""
        result = SUGGESTIONS.of(report)
        if result is None or not result.suggestions:
            return
        yield Line("")
        yield Line("# suggested requirements; to accept one, paste it, and add accepted_by and accepted_on", "dim")
        for suggestion in result.suggestions:
            yield from (Line(visible(text)) for text in toml_lines(suggestion))

    def of_requirement(self, report: Report, name: str) -> RequirementNote | None:
        """The evidence of a suggested requirement."""
        text = report.requirements.get(name)
        if text is None or not text.suggested:
            return None
        accepted = f"accepted by {text.accepted}" if text.accepted else "accepted by nobody"
        return RequirementNote(f"Suggested from runs ({text.suggested}), ", accepted, ".")

    def section(self, report: Report) -> PageSection | None:
        """All suggestions, each with its evidence."""
        result = SUGGESTIONS.of(report)
        if result is None:
            return None
        values = {
            "result": result,
            "headline": headline(result),
            "grounds": [*grounds(result)],
            "suggestions": [(suggestion, "\n".join(toml_lines(suggestion))) for suggestion in result.suggestions],
        }
        return PageSection("suggestions", "Suggestions", "suggestion/suggestions.html.jinja", values)


VIEW = SuggestionView()


def headline(result: SuggestionResult) -> str:
    """`suggestions: 12 requirements, of 34 runs, in 3 min 20 s`."""
    amount = plural(len(result.suggestions), "requirement")
    return (
        f"suggestions: {amount}, of {plural(result.runs + result.validation_runs, 'run')}, in {seconds(result.wall_s)}"
    )


def grounds(result: SuggestionResult) -> Iterator[str]:
    """What suggestions rest on, a sentence each."""
    left = result.candidates - result.refuted - len(result.suggestions) - result.more
    yield (
        f"{plural(result.candidates, 'candidate')} held in all runs; {result.refuted} not when runs continued, "
        f"{max(0, left)} redundant" + (f", {result.more} not shown" if result.more else "")
    )
    if result.faults:
        by = "exceptions" if result.ignores_existing else "requirements and exceptions"
        added = sum(suggestion.added for suggestion in result.suggestions)
        yield (
            f"{plural(result.faults, 'seeded bug')} changed a run: {result.noticed} noticed by {by}, {added} more by "
            "these suggestions"
        )


def toml_lines(suggestion: Suggestion) -> tuple[str, ...]:
    """A suggestion as it is pasted, in four lines."""
    formula = suggestion.formula
    quoted = f"'{formula}'" if "'" not in formula else f'"""{formula}"""'
    return (
        f"[{suggestion.id}]",
        f'title = "{suggestion.title}"',
        f"formula = {quoted}",
        f'suggested = "{evidence(suggestion)}"',
    )


def evidence(suggestion: Suggestion) -> str:
    """What a suggestion rests on, in some words."""
    parts = [f"{plural(suggestion.triggers, 'trigger')}, decisive in {plural(suggestion.decisive, 'run')}"]
    if suggestion.observed:
        parts.append(suggestion.observed)
    if suggestion.faults:
        only = f", {suggestion.new} of them noticed by no requirement" if suggestion.new else ""
        parts.append(f"notices {plural(suggestion.faults, 'seeded bug')}{only}")
    return "; ".join(parts)


class SuggestionFeature(Feature[SuggestionOptions]):
    """Suggests requirements that all runs satisfied."""

    name = "suggestion"
    options = (
        Flag(
            "suggest",
            "after all tests, suggest requirements that all of their runs satisfied; first those that detect the most "
            "seeded bugs that no existing requirement detects",
            shown=False,  # `hricdv suggest` has it
        ),
        Value("suggest-most", "N", f"suggest at most N requirements (default {SuggestionOptions.most})"),
        Value(
            "suggest-faults",
            "N",
            f"rank suggestions by N seeded bugs, drawn with the seed; 0: none (default {SuggestionOptions.faults})",
        ),
        Value(
            "suggest-further",
            "N",
            f"check suggestions in N more tests, with other parameters (default {SuggestionOptions.further})",
        ),
        Value("suggest-seconds", "S", "start no new bug after S seconds (default: no limit)"),
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
