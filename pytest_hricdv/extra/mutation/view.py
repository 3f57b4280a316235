"""`MutationView` shows mutants and scores in the terminal, on the page of the report, and in other outputs."""

import re
from collections.abc import Iterator, Mapping, Sequence

from pytest_hricdv._base.message import and_more, list_names, visible
from pytest_hricdv.extra.mutation.records import (
    MUTATION,
    MutantResult,
    MutantStatus,
    MutationResult,
    MutationScore,
    OracleScore,
)
from pytest_hricdv.report.formatting import Line, Style, natural, pad, percent, plural, seconds, width
from pytest_hricdv.report.view import PageSection, View
from pytest_hricdv.results.model import Report

_MAX_EXAMPLES = 5
_TOKEN = re.compile(r"\w+|\W")

WHY: Mapping[MutantStatus, str] = {
    "survived": "a record changed, and nothing failed: an oracle is missing",
    "unchanged": "no record changed: a stimulus is missing, or it is equivalent",
    "no coverage": "no test executes the statement",
    "not run": "time ran out before all of its tests had run",
}
"""Status of a mutant that was not killed -> what it means."""


class MutationView(View):
    """Shows mutation scores, and the mutants that were not killed."""

    name = "mutation"

    def lines(self, report: Report, columns: int) -> Iterator[Line]:
        """The scores, and the first mutants of each status but "killed"; nothing without mutation testing."""
        result = MUTATION.of(report)
        if result is None:
            return
        yield Line(headline(result), "title")
        if len(result.suites) > 1:
            for name, score in result.suites.items():
                yield Line(visible(f"  suite {name}: {score_text(score)}"))
        groups = {f"group {name}": score for name, score in result.groups.items()}
        yield from _oracle_lines({**_requirements_first(report, result.assertions), **groups})
        for status in WHY:
            yield from _example_lines([mutant for mutant in result.mutants if mutant.status == status], status)
        for text in notes(result):
            yield Line(visible(f"  {text}"), "warn")

    def section(self, report: Report) -> PageSection | None:
        """A section with all mutants, and what killed each."""
        result = MUTATION.of(report)
        if result is None:
            return None
        by_status = {
            status: [mutant for mutant in result.mutants if mutant.status == status] for status in ("killed", *WHY)
        }
        values = {
            "result": result,
            "meaning": meaning(result),
            "headline": headline(result),
            "notes": [*notes(result)],
            "oracles": _requirements_first(report, result.assertions),
            "alive": {status: (why, by_status[status]) for status, why in WHY.items() if by_status[status]},
            "killed": by_status["killed"],
            "change": change,
            "tests": {test.id: test for test in report.tests},
        }
        return PageSection("mutants", "Mutants", "mutation/mutants.html.jinja", values)

    def markdown(self, report: Report) -> Iterator[str]:
        """The score."""
        result = MUTATION.of(report)
        if result is not None:
            yield headline(result).capitalize()

    def properties(self, report: Report) -> Iterator[tuple[str, object]]:
        """The score."""
        result = MUTATION.of(report)
        if result is not None:
            yield "hri.mutants", score_text(result.total)


VIEW = MutationView()


def headline(result: MutationResult) -> str:
    """`mutants: 81.2 % killed (302 of 372), 1210 runs in 9 min 12 s`."""
    runs = sum(len(mutant.runs) for mutant in result.mutants)
    return f"mutants: {score_text(result.total)}, {plural(runs, 'run')} in {seconds(result.wall_s)}"


def meaning(result: MutationResult) -> str:
    """`The tests killed 302 of 372 mutants (81.2 %).`."""
    score = result.total
    if score.percent is None:
        return "No mutant was tried."
    tried = plural(score.mutants - score.not_run, "mutant")
    return f"The tests killed {score.killed} of {tried} ({percent(score.percent)})."


def score_text(score: MutationScore) -> str:
    """`81.2 % killed (302 of 372)`."""
    share = "none tried" if score.percent is None else f"{percent(score.percent)} killed"
    return f"{share} ({score.killed} of {score.mutants - score.not_run})"


def notes(result: MutationResult) -> Iterator[str]:
    """Sentences about the limits of a score."""
    if result.generated > len(result.mutants):
        yield f"{len(result.mutants)} of {result.generated} mutants were drawn"
    most = result.tests_per_mutant
    alive = [mutant for mutant in result.mutants if mutant.status in ("survived", "unchanged")]
    partly = sum(any(most is not None and count > most for count in mutant.executing.values()) for mutant in alive)
    if partly and most is not None:
        yield f"{partly} that were not killed were tried on {plural(most, 'test')} of a suite, and more execute them"
    if result.excluded_tests:
        excluded = plural(len(result.excluded_tests), "test")
        yield f"{excluded} left out: failing or unmeasured without a bug: {list_names(result.excluded_tests)}"
    if result.end_reason != "done":
        why = {"seconds": "time ran out", "lost": "their process was lost"}.get(result.end_reason, "it was interrupted")
        yield f"{plural(result.total.not_run, 'mutant')} not tried: {why}"


def _requirements_first(report: Report, oracles: Mapping[str, OracleScore]) -> dict[str, OracleScore]:
    """Sort requirements before other oracles, such as faults."""
    names = sorted(oracles, key=lambda name: (name not in report.requirements, natural(name)))
    return {name: oracles[name] for name in names}


def _oracle_lines(oracles: Mapping[str, OracleScore]) -> Iterator[Line]:
    room = max([9, *(width(visible(name)) for name in oracles)])
    yield Line(f"  {pad('killed by', room)}{'mutants':>9}{'only by it':>12}", "dim")
    for name, score in oracles.items():
        style: Style = "plain" if score.killed else "dim"
        yield Line(f"  {pad(visible(name), room)}{score.killed:>9}{score.killed_only_by:>12}", style)


def _example_lines(mutants: Sequence[MutantResult], status: MutantStatus) -> Iterator[Line]:
    if not mutants:
        return
    yield Line(f"  {len(mutants)} {status}: {WHY[status]}", "warn")
    for mutant in mutants[:_MAX_EXAMPLES]:
        yield Line(visible(f"    {_place(mutant)}  {mutant.operator}: {_change(mutant)}"))
        if mutant.difference:
            yield Line(visible(f"      {mutant.difference}"), "dim")
    if len(mutants) > _MAX_EXAMPLES:
        yield Line(f"    ...{and_more(len(mutants) - _MAX_EXAMPLES)}: see the report", "dim")


def _place(mutant: MutantResult) -> str:
    """`controller/robot.py:55`."""
    return f"{mutant.file}:{mutant.line}"


def _change(mutant: MutantResult) -> str:
    """The first line of the changed code, before and after."""
    before, after = (text.partition("\n")[0] for text in (mutant.before, mutant.after))
    return before if after in ("", "pass") else f"{before} -> {after}"


def change(mutant: MutantResult) -> tuple[str, str]:
    """The code before and after, in one line each, without most of what is equal: `…(wait_s)…`, `…(wait_s * 2)…`."""
    before, after = (
        _TOKEN.findall(" / ".join(map(str.strip, text.split("\n")))) for text in (mutant.before, mutant.after)
    )
    first = _common_length(before, after)
    last = _common_length(before[first:][::-1], after[first:][::-1])
    begin, end = max(0, first - 3), max(0, last - 3)

    def part(tokens: list[str]) -> str:
        shown = "".join(tokens[begin : len(tokens) - end])
        return f"{'…' if begin else ''}{shown}{'…' if end else ''}"

    return (part(before), part(after)) if mutant.after else ("".join(before), "")


def _common_length(first: Sequence[str], second: Sequence[str]) -> int:
    """The number of tokens at the start that two texts have in common."""
    return next(
        (n for n, (a, b) in enumerate(zip(first, second, strict=False)) if a != b), min(len(first), len(second))
    )
