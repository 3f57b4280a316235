"""A report in the formats of CI services: markdown for a job's summary, JUnit properties."""

from collections.abc import Iterator, Sequence

from pytest_hricdv._base.message import MAX_LINE, cut, visible
from pytest_hricdv.coverage.cross_records import CrossCoverage
from pytest_hricdv.coverage.records import CodeCoverage, PlanCoverage
from pytest_hricdv.report import behaviour_view, totals
from pytest_hricdv.report.explanation import instructions_of
from pytest_hricdv.report.failing_tests import MOST_ROWS, FailingTests
from pytest_hricdv.report.formatting import by_requirement, fit, percent, plural, seconds, share
from pytest_hricdv.report.margin import margin_text, margin_unit
from pytest_hricdv.report.markdown_text import escaped
from pytest_hricdv.report.view import views
from pytest_hricdv.report.violation_lines import failed_in_order, violation_line
from pytest_hricdv.results.model import Report, SuiteResult, TestResult

_MAX_FAILURES = 10
"""In the markdown of a job's summary; chosen, as is GitHub's limit of annotations: who has more opens the report."""
_MAX_SECTION_BYTES = 200_000
"""Of each of the summary's six sections (chosen: together they stay below GitHub's limit of 1 MiB)."""
_MAX_GAP_COLUMNS = 200
"""Of an entry with what is not covered; chosen: two or three lines of a browser."""


def markdown(report: Report) -> str:
    """The summary of a CI job: verdicts, coverage, failures and how to run them again.

    Names in it cannot break its tables, and it stays below GitHub's limit of 1 MiB, whatever a report has.
    """
    lines: list[str] = []
    for part in (_head, _causes, _requirements, _coverage, _failures, _gaps):
        section = [*_fitting(part(report))]
        if section:
            lines += [*section, ""]
    return "\n".join(lines)


def _fitting(lines: Iterator[str]) -> Iterator[str]:
    """The lines of a section, as far as there is room; what is open then is closed."""
    room, fence, details = _MAX_SECTION_BYTES, "", 0
    for line in lines:
        # Not cut: half of an escape sequence or a tag would change what comes after it.
        room -= len(line.encode(errors="replace")) + 1
        if room < 0:
            yield from ([fence] if fence else [])
            yield "\n... and more, for which there is no room here: see the report."
            yield from ["</details>"] * details
            return
        yield line
        details += line.startswith("<details>") - (line == "</details>")
        if fence:
            fence = "" if line == fence else fence
        elif line.startswith("```") and line.endswith("`text"):
            fence = line.removesuffix("text")


def junit_properties(test: TestResult, outcome_label: str) -> tuple[tuple[str, str], ...]:
    """JUnit properties of a test, as name and value: suite, id, seed, verdicts, coverage, simulation, outcomes.

    What a test does not have, such as the coverage of unmeasured code, has no property: some tools would read an empty
    one as zero. Nor has its own outcome, which JUnit XML states itself, and which is not known yet while the test runs.

    Args:
        test: its result.
        outcome_label: what the testbench calls the interactions.
    """
    pairs: list[tuple[str, object]] = [
        ("hri.suite", test.suite),
        ("hri.id", test.id),
        ("hri.seed", test.seed),
        *((f"hri.{name}", test.requirements[name].verdict) for name in sorted(test.requirements, key=by_requirement)),
        ("hri.statements_percent", _tenths(test.code.percent if test.code else None)),
        ("hri.simulated_s", _tenths(test.sim_s)),
        ("hri.fidelity", test.fidelity or None),
        ("hri.engine", " ".join(test.engines) or None),
        (f"hri.{outcome_label}", " ".join(test.outcomes)),
        ("hri.record_sha256", test.record_sha256),
        *(("hri.fault", fault) for fault in test.faults),
    ]
    return _text_pairs(pairs)


def junit_suite_properties(report: Report) -> tuple[tuple[str, str], ...]:
    """JUnit properties of the XML's `testsuite`: what was run, and verdicts and coverage (per cent) by suite."""
    pairs: list[tuple[str, object]] = [
        ("hri.testbench", report.testbench),
        ("hri.version", report.version),
        ("hri.expected", report.selected),
        ("hri.reported", report.reported),
        ("hri.code_sha256", report.code_under_test.sha256 or None),
    ]
    for suite in report.suites:
        pairs += [(f"hri.{suite.name}.{name}", value) for name, value in _suite_figures(suite)]
    pairs += [("hri.failed_gate", text) for text in totals.failed_gates(report)]
    if report.changes is not None:
        pairs.append(("hri.behave_otherwise", len(report.changes.changed)))
    pairs += [pair for view in views() for pair in view.properties(report)]
    return _text_pairs(pairs)


def _head(report: Report) -> Iterator[str]:
    time = totals.duration(report)
    loss, failed = totals.loss(report), totals.failed_gates(report)
    bad = totals.has_failed(report) or failed or loss
    outcome = "failed" if bad else "nothing checked" if totals.nothing_checked(report) else "passed"
    yield f"## Human-robot interaction: {_escaped(report.testbench)}, {outcome}"
    yield ""
    unchecked = ". ".join(f"{text[0].upper()}{text[1:]}" for text in totals.nothing_checked(report))
    if unchecked:
        yield f"**{_escaped(unchecked)}.**\n"
    lost = f" **{loss}.**" if loss else ""
    yield f"Tests: {totals.outcomes_text(report)}. Expected {report.selected}, reported {report.reported}.{lost} "
    yield f"Simulated {seconds(time.simulated_s)} in {seconds(time.wall_s)}."
    for text in failed:
        yield f"\n**FAILED** {_escaped(text)}"
    for text in report.gates.improved if report.gates else ():
        yield f"\nBetter: {_escaped(text)}"
    if sentence := behaviour_view.sentence(report):
        yield f"\nBehaviour: {_escaped(sentence)}"
    for view in views():
        yield from (f"\n{_escaped(text)}" for text in view.markdown(report))


def _causes(report: Report) -> Iterator[str]:
    """What tests fail for: of each cause what the terminal says, and its tests."""
    failing = FailingTests.of(report)
    if failing.causes is None:
        return
    yield f"### {_escaped(failing.causes.headline)}"
    yield ""
    for cause, nodeids in failing.groups:
        if cause is None:
            continue
        yield f"**{_escaped(cause.title)}**"
        yield ""
        yield from _fenced([line.text for line in cause.lines[1:]])
        if len(nodeids) > 1:
            yield f"<details><summary>{plural(len(nodeids), 'test')}</summary>"
            yield ""
            yield from _fenced([line.text.strip() for line in failing.rows(nodeids[:MOST_ROWS])])
            yield "</details>"
        yield ""
    yield _escaped(failing.causes.remark)


def _requirements(report: Report) -> Iterator[str]:
    for suite in report.suites:
        yield f"### Suite {_escaped(suite.name)}, seed {suite.seed}: {totals.tests_text(report, suite)}"
        yield ""
        yield "| requirement | passed | failed | NC | triggers | least margin |"
        yield "|---|---:|---:|---:|---:|---:|"
        for row in totals.requirement_rows(report, suite):
            failed = f"**{row.failed}**" if row.failed and not row.tolerated else str(row.failed)
            note = f" known: {_escaped(row.known_note)}" if row.failed and row.known_reason else ""
            margin = "" if row.margin is None else _escaped(margin_text(row.margin, row.unit, ".3g"))
            name = _escaped(f"{row.name} {row.title}")
            yield f"| {name} | {row.passed} | {failed}{note} | {row.nc} | {row.triggers} | {margin} |"
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
    examples = FailingTests.of(report).examples
    failed = sorted(
        (test for test in report.tests if test.fails),
        key=lambda test: examples.index(test.nodeid) if test.nodeid in examples else len(examples),
    )
    if not failed:
        return
    yield f"### {plural(len(failed), 'failure')}"
    yield ""
    for test in failed[:_MAX_FAILURES]:
        yield from _failure(report, test)
    if len(failed) > _MAX_FAILURES:
        yield f"... and {len(failed) - _MAX_FAILURES} more: see the report."


def _failure(report: Report, test: TestResult) -> Iterator[str]:
    names = failed_in_order(test, {} if report.strict else report.known_violations)
    causes = ", ".join([*names, *(["fault"] if test.faults else [])]) or "in error"
    yield f"<details><summary><b>{_escaped(test.id)}</b>: {_escaped(causes)}</summary>"
    yield ""
    for name in names:
        unit = margin_unit(report, name)
        for violation in test.requirements[name].violations[:1]:
            yield f"- {_escaped(name)} {_escaped(violation_line(violation, report.units or {}, unit))}"
    yield from (f"- {_escaped(fault)}" for fault in test.faults)
    if not (names or test.faults):
        yield from (f"- {_escaped(line)}" for line in test.failure.strip().splitlines()[:1])
    yield ""
    yield from _fenced(instructions_of(report, test))
    yield "</details>"
    yield ""


def _gaps(report: Report) -> Iterator[str]:
    gaps = totals.gaps(report)
    if not gaps:
        return
    yield "<details><summary>Not covered</summary>"
    yield ""
    for gap in gaps:
        yield f"- {_escaped(gap.place)} {gap.kind}: {_escaped(fit(', '.join(gap.items), _MAX_GAP_COLUMNS))}"
    yield ""
    yield "</details>"


def _fenced(lines: Sequence[str]) -> Iterator[str]:
    """Lines as a code block; its fence is longer than any sequence of backquotes inside."""
    text = [visible(cut(line, MAX_LINE)) for line in lines]
    longest = max((len(part) for line in text for part in _backquotes(line)), default=0)
    fence = "`" * max(3, longest + 1)
    yield f"{fence}text"
    yield from text
    yield fence


def _escaped(text: str) -> str:
    return escaped(cut(text, MAX_LINE))


def _backquotes(line: str) -> list[str]:
    return "".join(char if char == "`" else " " for char in line).split()


def _suite_figures(suite: SuiteResult) -> Iterator[tuple[str, object]]:
    yield "seed", suite.seed
    yield "tests", suite.tests
    for name in sorted(suite.requirements, key=by_requirement):
        tally = suite.requirements[name]
        yield name, f"{tally.passed} passed, {tally.failed} failed, {tally.nc} NC"
    for kind, coverage in (("statements", suite.code.statements), ("branches", suite.code.branches)):
        yield f"{kind}_percent", _tenths(coverage.percent_reachable if coverage else None)
    for agent, plans in sorted(suite.plans.items()):
        yield f"plans_of_{agent}_percent", _tenths(share(len(plans.covered), plans.total))
    yield "cross_percent", _tenths(totals.bins_covered(suite.cross))


def _tenths(value: float | None) -> str | None:
    return None if value is None else f"{value:.1f}"


def _text_pairs(pairs: list[tuple[str, object]]) -> tuple[tuple[str, str], ...]:
    # pytest escapes values for XML, but not names.
    return tuple(
        (visible(cut(name, MAX_LINE)), cut(str(value), MAX_LINE)) for name, value in pairs if value is not None
    )
