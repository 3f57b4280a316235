"""Results as JUnit properties, of tests and of the whole, for tools that read nothing but JUnit XML."""

from collections.abc import Iterator

from pytest_hricdv.report import totals
from pytest_hricdv.report.formatting import natural, share
from pytest_hricdv.results.model import Report, SuiteResult, TestResult


def properties(test: TestResult, outcome_label: str = "outcomes") -> tuple[tuple[str, str], ...]:
    """Name and value pairs for `item.user_properties`: suite, id, seed, verdicts, coverage, fidelity, outcomes.

    What a test does not have, such as the coverage of unmeasured code, has no property: some tools would read an empty
    one as zero. Nor has its own outcome, which JUnit XML states itself, and which is not known yet while the test runs.

    Args:
        test: its result.
        outcome_label: what the testbench calls the outcomes of interactions.
    """
    pairs: list[tuple[str, object]] = [
        ("hri.suite", test.suite),
        ("hri.id", test.id),
        ("hri.seed", test.seed),
        *((f"hri.{name}", test.requirements[name].verdict) for name in sorted(test.requirements, key=natural)),
        ("hri.statements_percent", _tenths(test.code.percent if test.code else None)),
        ("hri.simulated_s", _tenths(test.sim_s)),
        ("hri.fidelity", test.fidelity or None),
        (f"hri.{outcome_label}", " ".join(test.outcomes)),
        ("hri.record_sha256", test.record_sha256),
    ]
    return _text_pairs(pairs)


def suite_properties(report: Report) -> tuple[tuple[str, str], ...]:
    """Name and value pairs for the XML's `testsuite`: what was run, and verdicts and coverage (per cent) by suite."""
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
    return _text_pairs(pairs)


def _suite_figures(suite: SuiteResult) -> Iterator[tuple[str, object]]:
    yield "seed", suite.seed
    yield "tests", suite.tests
    for name in sorted(suite.requirements, key=natural):
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
    return tuple((name, str(value)) for name, value in pairs if value is not None)
