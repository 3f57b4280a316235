"""`Subject`: the tests, failures and executed statements of a report, as the input that all steps of a diagnosis share.

`diagnose`, `merging` and `triage` make it with `Subject.of`; `groups` returns the failures grouped by probable cause.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pytest_hricdv.coverage.code_map import Bits, CodeMap
from pytest_hricdv.extra.diagnosis.failures import Failure, failures_of
from pytest_hricdv.extra.diagnosis.grouping import ExperimentEvidence, Group, group_failures
from pytest_hricdv.extra.diagnosis.spectrum import Spectra
from pytest_hricdv.generate.abstract import disturbance_of
from pytest_hricdv.results.model import Report, TestResult


@dataclass(frozen=True)
class Subject:
    """The tests of a report whose runs ended, by node id, their failures, and which statements each executed."""

    report: Report
    tests: Mapping[str, TestResult]
    failures: tuple[Failure, ...]
    spectra: Spectra

    @classmethod
    def of(cls, report: Report) -> Subject:
        """The subject of a report."""
        tests = {test.nodeid: test for test in report.tests if test.timeline is not None}
        declared = {} if report.strict else report.known_violations
        failures = tuple(failure for test in tests.values() for failure in failures_of(test, report.state, declared))
        bits = {name: measured for name, test in tests.items() if (measured := Bits.of(test.code)) is not None}
        return cls(report, tests, failures, Spectra(CodeMap.of(report.code_under_test), bits))

    def groups(self, evidence: ExperimentEvidence) -> tuple[Group, ...]:
        """Failures that have probably one cause."""
        disturbances = {name: _disturbances(test) for name, test in self.tests.items()}
        return group_failures(disturbances, self.failures, self.spectra, evidence)

    def find_violators(self, group: Group) -> set[str]:
        """Node ids of tests that violate the same requirements, for this cause or another, and so have not passed."""
        return {failure.nodeid for failure in self.failures if failure.requirement in group.requirements}

    def compares(self, group: Group) -> bool:
        """Whether the code was measured in a run that fails for the cause, and in one that passes."""
        measured = self.spectra.bits.keys()
        return not measured.isdisjoint(group.nodeids) and bool(measured - {*group.nodeids} - self.find_violators(group))


def _disturbances(test: TestResult) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for line in test.abstract if (name := disturbance_of(line)) is not None))
