"""The false alarms of a session: all that fails it, and its known violations, by requirement."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from pytest_hricdv.execution.outcome import AS_DECLARED, is_declared
from pytest_hricdv.results.model import Report, TestResult

RUN, SESSION = "the run", "the session"
"""What fails beside requirements: a test by a fault of its run, a session by one of its gates."""


@dataclass(frozen=True)
class Alarm:
    """Something that failed.

    Args:
        oracle: a requirement, or `RUN` or `SESSION`.
        where: the id of the test; of a gate: the suite.
        seed: of the suite.
        text: what was wrong.
    """

    oracle: str
    where: str
    seed: int
    text: str


@dataclass(frozen=True)
class Judged:
    """A requirement over the runs of a session.

    Args:
        runs: that triggered it.
        triggers: how often they did.
        known_violations: runs in which all its violations are known.
        margin: the least one; None where it has none.
        test: the id of the test that had it.
    """

    runs: int
    triggers: int
    known_violations: int
    margin: float | None
    test: str


@dataclass(frozen=True)
class Found:
    """What the runs of a session showed."""

    suite: str
    seed: int
    runs: int
    alarms: tuple[Alarm, ...]
    requirements: Mapping[str, Judged]
    titles: Mapping[str, str]
    version: str
    code_sha256: str


def found_in(suite: str, seed: int, report: Report) -> Found:
    """What the runs of a session showed, of its report."""
    alarms = [alarm for test in report.tests for alarm in _alarms(test, seed, report.known_violations)]
    gates = report.gates.failed if report.gates else ()
    return Found(
        suite=suite,
        seed=seed,
        runs=len(report.tests),
        alarms=(*alarms, *(Alarm(SESSION, suite, seed, text) for text in gates)),
        requirements={name: _judged(name, report) for name in report.requirements},
        titles={name: text.title for name, text in report.requirements.items()},
        version=report.version,
        code_sha256=report.code_under_test.sha256,
    )


def _alarms(test: TestResult, seed: int, declared: Mapping[str, str]) -> Iterator[Alarm]:
    """Of a test that failed: the requirements that it violated, or what else was wrong with its run."""
    if test.outcome in AS_DECLARED:
        return
    unknown = [name for name in test.requirements if test.violates(name) and not _is_known(name, test, declared)]
    for name in unknown:
        violations = test.requirements[name].violations
        first = next((violation for violation in violations if violation.outside), violations[0])
        values = ", ".join(f"{value} = {number}" for value, number in first.values.items())
        yield Alarm(name, test.id, seed, f"at {first.time_s} s: {first.text or values}")
    faults = test.errors or (() if unknown else (test.failure.strip().splitlines() or [test.outcome])[-1:])
    for fault in faults:
        yield Alarm(RUN, test.id, seed, fault)


def _is_known(name: str, test: TestResult, declared: Mapping[str, str]) -> bool:
    """Whether the violations of a requirement in a test are known."""
    return is_declared(name, declared, outside=test.requirements[name].outside)


def _judged(name: str, report: Report) -> Judged:
    results = [(test, test.requirements[name]) for test in report.tests if name in test.requirements]
    margins = [(result.margin, test.id) for test, result in results if result.margin is not None]
    margin, where = min(margins, default=(None, ""))
    return Judged(
        runs=sum(result.triggers > 0 for _, result in results),
        triggers=sum(result.triggers for _, result in results),
        known_violations=sum(
            test.violates(name) and _is_known(name, test, report.known_violations) for test, _ in results
        ),
        margin=margin,
        test=where,
    )
