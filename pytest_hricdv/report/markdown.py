"""The report as markdown for the summary of a CI job: verdicts, coverage, failures and how to run them again."""

from collections.abc import Iterator, Sequence

from pytest_hricdv.coverage.records import CodeCoverage, CrossCoverage, PlanCoverage
from pytest_hricdv.report import totals
from pytest_hricdv.report.explanation import violation
from pytest_hricdv.report.formatting import fit, natural, percent, plural, seconds, share, visible
from pytest_hricdv.report.gaps import gaps
from pytest_hricdv.report.rerun import instructions_of
from pytest_hricdv.results.model import Report, TestResult

_MAX_FAILURES = 10
_MAX_GAP_COLUMNS = 200
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
}


def markdown(report: Report) -> str:
    """The summary's text; names in it cannot break its tables, and it stays far below GitHub's limit of 1 MiB."""
    lines: list[str] = []
    for part in (_head(report), _requirements(report), _coverage(report), _failures(report), _gaps(report)):
        section = list(part)
        if section:
            lines += [*section, ""]
    return "\n".join(lines)


def _head(report: Report) -> Iterator[str]:
    counts, time = totals.outcomes(report), totals.duration(report)
    loss, failed = totals.loss(report), totals.failed_gates(report)
    bad = counts["failed"] or counts["error"] or failed or loss
    yield f"## Human-robot interaction: {_escaped(report.testbench)}, {'failed' if bad else 'passed'}"
    yield ""
    lost = f" **{loss}.**" if loss else ""
    yield f"Tests: {totals.outcomes_text(report)}. Expected {report.selected}, reported {report.reported}.{lost} "
    yield f"Simulated {seconds(time.simulated_s)} in {seconds(time.wall_s)}."
    for text in failed:
        yield f"\n**FAILED** {_escaped(text)}"
    for text in report.gates.improved if report.gates else ():
        yield f"\nBetter: {_escaped(text)}"


def _requirements(report: Report) -> Iterator[str]:
    for suite in report.suites:
        yield f"### Suite {_escaped(suite.name)}, seed {suite.seed}: {plural(suite.tests, 'test')}"
        yield ""
        yield "| requirement | passed | failed | NC | triggers | least margin |"
        yield "|---|---:|---:|---:|---:|---:|"
        for row in totals.requirement_rows(report, suite):
            failed = f"**{row.failed}**" if row.failed and not row.known else str(row.failed)
            known = f" known: {_escaped(row.known)}" if row.failed and row.known else ""
            margin = "" if row.margin is None else f"{row.margin:.3g}"
            name = _escaped(f"{row.name} {row.title}")
            yield f"| {name} | {row.passed} | {failed}{known} | {row.nc} | {row.triggers} | {margin} |"
        yield ""
    if report.suites:
        yield "NC: not checked, because nothing in the run triggered the requirement."


def _coverage(report: Report) -> Iterator[str]:
    suites = report.suites
    if not suites:
        return
    yield f"| coverage | {' | '.join(_escaped(suite.name) for suite in suites)} |"
    yield f"|---|{'---:|' * len(suites)}"
    yield f"| statements, of the reachable | {' | '.join(_code(suite.code.statements) for suite in suites)} |"
    yield f"| branches, of the reachable | {' | '.join(_code(suite.code.branches) for suite in suites)} |"
    for agent in sorted({agent for suite in suites for agent in suite.plans}):
        yield f"| plans of {_escaped(agent)} | {' | '.join(_plans(suite.plans.get(agent)) for suite in suites)} |"
    if any(suite.cross.bins for suite in suites):
        yield f"| cross products, of the possible | {' | '.join(_cross(suite.cross) for suite in suites)} |"
    if any(suite.code.statements is None for suite in suites):
        yield f"\nThe code was not measured: {_escaped(totals.unmeasured(report))}."


def _code(coverage: CodeCoverage | None) -> str:
    return f"{percent(coverage.percent_reachable)} of {coverage.reachable}" if coverage else "unmeasured"


def _plans(plans: PlanCoverage | None) -> str:
    return f"{percent(share(len(plans.covered), plans.total))} of {plans.total}" if plans else ""


def _cross(cross: CrossCoverage) -> str:
    return f"{percent(totals.bins_covered(cross))} of {cross.possible}" if cross.possible else ""


def _failures(report: Report) -> Iterator[str]:
    failed = [test for test in report.tests if test.outcome in ("failed", "error")]
    if not failed:
        return
    yield f"### {plural(len(failed), 'failure')}"
    yield ""
    for test in failed[:_MAX_FAILURES]:
        yield from _failure(report, test)
    if len(failed) > _MAX_FAILURES:
        yield f"... and {len(failed) - _MAX_FAILURES} more: see the report."


def _failure(report: Report, test: TestResult) -> Iterator[str]:
    names = sorted((name for name, result in test.requirements.items() if result.verdict == "Failed"), key=natural)
    what = ", ".join(names) if names else "in error"
    yield f"<details><summary><b>{_escaped(test.id)}</b>: {_escaped(what)}</summary>"
    yield ""
    for name in names:
        for found in test.requirements[name].violations[:1]:
            yield f"- {_escaped(name)} {_escaped(violation(found, report.units or {}))}"
    if not names:
        yield from (f"- {_escaped(line)}" for line in test.failure.strip().splitlines()[:1])
    yield ""
    yield from _fenced(instructions_of(report, test))
    yield "</details>"
    yield ""


def _gaps(report: Report) -> Iterator[str]:
    found = gaps(report)
    if not found:
        return
    yield "<details><summary>Not covered</summary>"
    yield ""
    for gap in found:
        yield f"- {_escaped(gap.place)} {gap.kind}: {_escaped(fit(', '.join(gap.items), _MAX_GAP_COLUMNS))}"
    yield ""
    yield "</details>"


def _fenced(lines: Sequence[str]) -> Iterator[str]:
    """Lines as a code block; its fence is longer than any sequence of backquotes inside."""
    text = [visible(line) for line in lines]
    longest = max((len(part) for line in text for part in _backquotes(line)), default=0)
    fence = "`" * max(3, longest + 1)
    yield f"{fence}text"
    yield from text
    yield fence


def _backquotes(line: str) -> list[str]:
    return "".join(char if char == "`" else " " for char in line).split()


def _escaped(text: str) -> str:
    """Text without any markup of markdown or HTML."""
    return "".join(_SPECIAL.get(char, char) for char in visible(text))
