"""Properties of JUnit XML, which CI services show: of a test, for `TestRunner`, and of the session, for `Exporter`."""

from collections.abc import Iterator

from pytest_hricdv._base.message import MAX_LINE, cut, visible
from pytest_hricdv.report import totals
from pytest_hricdv.report.formatting import by_requirement, share
from pytest_hricdv.report.view import views
from pytest_hricdv.results.model import Report, SuiteResult, TestResult


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
        *(("hri.fault", fault) for fault in test.errors),
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
    pairs += [("hri.failed_gate", text) for text in totals.list_gate_failures(report)]
    if report.changes is not None:
        pairs.append(("hri.behave_otherwise", len(report.changes.changed)))
    pairs += [pair for view in views() for pair in view.properties(report)]
    return _text_pairs(pairs)


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
