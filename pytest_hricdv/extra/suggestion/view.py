"""How a report shows suggested requirements: lines to paste into a requirements file, and a section of its page."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.suggestion.records import SUGGESTIONS, Suggestion, SuggestionResult
from pytest_hricdv.report.formatting import Line, plural, seconds
from pytest_hricdv.report.view import PageSection, RequirementNote, View
from pytest_hricdv.results.model import Report


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
        f"{plural(result.candidates, 'candidate')} held in all runs; further tests refuted {result.refuted}, "
        f"{max(0, left)} redundant" + (f", {result.more} not shown" if result.more else "")
    )
    if result.faults:
        by = "exceptions" if result.ignores_existing else "requirements and exceptions"
        added = sum(suggestion.added for suggestion in result.suggestions)
        yield (
            f"{plural(result.faults, 'seeded fault')} changed a run: {result.noticed} noticed by {by}, {added} more by "
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
    if suggestion.validation_runs:
        parts.append(f"{suggestion.validation_runs} further tests did not refute it")
    if suggestion.faults:
        only = f", {suggestion.new} of which no requirement does" if suggestion.new else ""
        parts.append(f"notices {plural(suggestion.faults, 'seeded fault')}{only}")
    return "; ".join(parts)
