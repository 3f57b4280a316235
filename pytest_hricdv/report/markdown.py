"""`markdown`: the summary of a CI job, which `exports` writes. Text in a report becomes no markup, link or mention.
GitHub and GitLab turn more than markup into links: bare addresses, `@team`, which notifies a team, and `#123`, which
adds a note to an issue. Backslashes do not prevent this, since both search the rendered text; a zero-width space does.
It is written as an entity, as dependency bots do in quotations.
"""

import re
from collections.abc import Iterator, Sequence

from pytest_hricdv._base.message import MAX_LINE, cut, visible
from pytest_hricdv.coverage.cross_product import CrossCoverage
from pytest_hricdv.coverage.records import CodeCoverage, PlanCoverage
from pytest_hricdv.report import behaviour_view, totals
from pytest_hricdv.report.annotations import MAX_ANNOTATIONS
from pytest_hricdv.report.explanation import instructions_of
from pytest_hricdv.report.failing_tests import FailingTests
from pytest_hricdv.report.formatting import capitalize, fit, percent, plural, seconds, share, split_first
from pytest_hricdv.report.view import views
from pytest_hricdv.report.violations import margin_text, margin_unit, order_failures, violation_line
from pytest_hricdv.results.model import Report, TestResult

_MAX_SECTION_BYTES = 2**20 // 7
"""Most bytes of a section: a seventh of GitHub's limit of 1 MiB, for six sections and their closing texts."""

_MAX_ROWS = 40
"""Number of tests listed for each cause."""

_CUT = "&#8203;"

_SPECIAL = {
    "\\": "\\\\",
    "&": "&amp;",
    "<": "&lt;",
    ">": "&gt;",
    "|": "\\|",
    "`": "\\`",
    "*": "\\*",
    "_": "\\_",
    "[": "\\[",
    "#": "\\#",
    "~": "\\~",
    "$": "&#36;",  # a backslash before it is no escape where GitHub looks for formulas
}

_LINKED = re.compile(
    r"@"  # people, teams, addresses of mail
    r"|[#!%~$&^](?=[\w\"])"  # issues; of GitLab: merge requests, milestones, labels, snippets, epics, iterations
    r"|:(?=//)|(?:mailto|xmpp):|www(?=\.)|GH-(?=\d)",
    re.IGNORECASE,
)
"""The beginning of a link, up to where it is broken. From GitHub's documentation on autolinked references, GitLab's
on special references, and GitHub Flavored Markdown, 6.9, Autolinks (extension)."""


def markdown(report: Report) -> str:
    """The summary of a CI job: verdicts, coverage, failures and how to run them again.

    Names cannot break its tables, and it stays below GitHub's limit of 1 MiB for any report.
    """
    lines: list[str] = []
    for part in (_head, _causes, _requirements, _coverage, _failures, _gaps):
        section = [*_fit_section(part(report))]
        if section:
            lines += [*section, ""]
    return "\n".join(lines)


def _fit_section(lines: Iterator[str]) -> Iterator[str]:
    """The lines of a section, as far as there is room; what is open then is closed."""
    room, fence, details = _MAX_SECTION_BYTES, "", 0
    for line in lines:
        # Not cut: half of an escape sequence or a tag would change what comes after it.
        room -= len(line.encode(errors="replace")) + 1
        if room < 0:
            yield from ([fence] if fence else [])
            yield "\n... and more: see the report."
            yield from ["</details>"] * details
            return
        yield line
        details += line.startswith("<details>") - (line == "</details>")
        if fence:
            fence = "" if line == fence else fence
        elif line.startswith("```") and line.endswith("`text"):
            fence = line.removesuffix("text")


def _head(report: Report) -> Iterator[str]:
    time = totals.duration(report)
    loss, failed = totals.loss(report), totals.list_gate_failures(report)
    bad = totals.has_failed(report) or failed or loss
    outcome = "failed" if bad else "nothing checked" if totals.list_vacuity_warnings(report) else "passed"
    yield f"## Human-robot interaction: {_escape(report.testbench)}, {outcome}"
    yield ""
    unchecked = ". ".join(map(capitalize, totals.list_vacuity_warnings(report)))
    if unchecked:
        yield f"**{_escape(unchecked)}.**\n"
    lost = f" **{loss}.**" if loss else ""
    yield f"Tests: {totals.outcomes_text(report)}. {report.reported}/{report.selected} tests reported.{lost} "
    yield f"Simulated {seconds(time.simulated_s)} in {seconds(time.wall_s)}."
    for text in failed:
        yield f"\n**FAILED** {_escape(text)}"
    for text in report.gates.improved if report.gates else ():
        yield f"\nBetter: {_escape(text)}"
    if sentence := behaviour_view.sentence(report):
        yield f"\nBehaviour: {_escape(sentence)}"
    for view in views():
        yield from (f"\n{_escape(text)}" for text in view.markdown(report))


def _causes(report: Report) -> Iterator[str]:
    """Why tests fail: the terminal's text for each cause, and its tests."""
    failing = FailingTests.of(report)
    if failing.causes is None:
        return
    yield f"### {_escape(failing.causes.headline)}"
    yield ""
    for cause, nodeids in failing.groups:
        if cause is None:
            continue
        yield f"**{_escape(cause.title)}**"
        yield ""
        yield from _fence([line.text for line in cause.lines[1:]])
        if len(nodeids) > 1:
            yield f"<details><summary>{plural(len(nodeids), 'test')}</summary>"
            yield ""
            yield from _fence([line.text.strip() for line in failing.rows(nodeids[:_MAX_ROWS])])
            yield "</details>"
        yield ""
    yield _escape(failing.causes.remark)


def _requirements(report: Report) -> Iterator[str]:
    for suite in report.suites:
        yield f"### Suite {_escape(suite.name)}, seed {suite.seed}: {totals.tests_text(report, suite)}"
        yield ""
        yield "| requirement | passed | failed | NC | triggers | least margin |"
        yield "|---|---:|---:|---:|---:|---:|"
        for row in totals.requirement_rows(report, suite):
            failed = f"**{row.failed}**" if row.failed and not row.is_tolerated else str(row.failed)
            note = f" known: {_escape(row.xfail_note)}" if row.failed and row.known_reason else ""
            margin = "" if row.margin is None else _escape(margin_text(row.margin, row.unit, ".3g"))
            name = _escape(f"{row.name} {row.title}")
            yield f"| {name} | {row.passed} | {failed}{note} | {row.nc} | {row.triggers} | {margin} |"
        yield ""
    if report.suites:
        yield "NC: not checked, because nothing in the run triggered the requirement."


def _coverage(report: Report) -> Iterator[str]:
    suites = report.suites
    if not suites:
        return
    yield f"| coverage | {' | '.join(_escape(suite.name) for suite in suites)} |"
    yield f"|---|{'---:|' * len(suites)}"
    yield f"| statements, of the reachable | {' | '.join(_code(suite.code.statements) for suite in suites)} |"
    yield f"| branches, of the reachable | {' | '.join(_code(suite.code.branches) for suite in suites)} |"
    for agent in sorted({agent for suite in suites for agent in suite.plans}):
        yield f"| plans of {_escape(agent)} | {' | '.join(_plans(suite.plans.get(agent)) for suite in suites)} |"
    if any(suite.cross.bins for suite in suites):
        yield f"| cross products, of the possible | {' | '.join(_cross(suite.cross) for suite in suites)} |"
    if any(suite.code.statements is None for suite in suites):
        yield f"\nThe code was not measured: {_escape(totals.explain_no_coverage(report))}."


def _code(coverage: CodeCoverage | None) -> str:
    return f"{percent(coverage.percent_reachable)} of {coverage.reachable}" if coverage else "unmeasured"


def _plans(plans: PlanCoverage | None) -> str:
    return f"{percent(share(len(plans.covered), plans.total))} of {plans.total}" if plans else ""


def _cross(cross: CrossCoverage) -> str:
    return f"{percent(totals.bins_covered(cross))} of {cross.possible}" if cross.possible else ""


def _failures(report: Report) -> Iterator[str]:
    examples = FailingTests.of(report).examples
    failed = sorted(
        (test for test in report.tests if test.fails),
        key=lambda test: examples.index(test.nodeid) if test.nodeid in examples else len(examples),
    )
    if not failed:
        return
    yield f"### {plural(len(failed), 'failure')}"
    yield ""
    first, more = split_first(failed, MAX_ANNOTATIONS)
    for test in first:
        yield from _failure(report, test)
    if more:
        yield f"... and {more} more: see the report."


def _failure(report: Report, test: TestResult) -> Iterator[str]:
    names = order_failures(test, {} if report.strict else report.known_violations)
    causes = ", ".join([*names, *(["fault"] if test.errors else [])]) or "in error"
    yield f"<details><summary><b>{_escape(test.id)}</b>: {_escape(causes)}</summary>"
    yield ""
    for name in names:
        unit = margin_unit(report, name)
        for violation in test.requirements[name].violations[:1]:
            yield f"- {_escape(name)} {_escape(violation_line(violation, report.units or {}, unit))}"
    yield from (f"- {_escape(fault)}" for fault in test.errors)
    if not (names or test.errors):
        yield from (f"- {_escape(line)}" for line in test.failure.strip().splitlines()[:1])
    yield ""
    yield from _fence(instructions_of(report, test))
    yield "</details>"
    yield ""


def _gaps(report: Report) -> Iterator[str]:
    gaps = totals.gaps(report)
    if not gaps:
        return
    yield "<details><summary>Not covered</summary>"
    yield ""
    for gap in gaps:
        yield f"- {_escape(gap.place)} {gap.kind}: {_escape(fit(', '.join(gap.items), 200))}"
    yield ""
    yield "</details>"


def _fence(lines: Sequence[str]) -> Iterator[str]:
    """Lines as a code block; its fence is longer than any sequence of backquotes inside."""
    text = [visible(cut(line, MAX_LINE)) for line in lines]
    longest = max((len(part) for line in text for part in _backquotes(line)), default=0)
    fence = "`" * max(3, longest + 1)
    yield f"{fence}text"
    yield from text
    yield fence


def _escape(text: str) -> str:
    return escape_markdown(cut(text, MAX_LINE))


def _backquotes(line: str) -> list[str]:
    return "".join(char if char == "`" else " " for char in line).split()


def escape_markdown(text: str) -> str:
    """A text without any meaning in markdown or HTML, and without invisible characters."""
    pieces: list[str] = []
    end = 0
    shown = visible(text)
    for link in _LINKED.finditer(shown):
        pieces += [_plain(shown[end : link.end()]), _CUT]
        end = link.end()
    return "".join([*pieces, _plain(shown[end:])])


def _plain(text: str) -> str:
    return "".join(_SPECIAL.get(char, char) for char in text)
