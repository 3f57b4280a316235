"""The baseline: what a run reached earlier, kept under version control to find what got worse."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final, Literal

from msgspec import to_builtins

from pytest_hricdv.atomic_file import write_text
from pytest_hricdv.coverage.records import Count, Names, Number, Record
from pytest_hricdv.results.codec import MalformedError, decode_located
from pytest_hricdv.results.derivation import percentages
from pytest_hricdv.results.gates import KINDS
from pytest_hricdv.results.model import Report, SuiteResult, TestResult

SCHEMA: Final = "hricdv-baseline/1"


class BaselineError(Exception):
    """A baseline cannot be read, written or compared with; the text says which file, why, and what to do."""


class SuiteBaseline(Record, frozen=True, kw_only=True):
    """What one suite reached: violating tests by requirement, tests in error, triggers, percentages, plans, bins."""

    violations: Mapping[str, Names]
    broken: Names
    triggers: Mapping[str, Count]
    percent: Mapping[str, Number | None]
    plans: Mapping[str, Names]
    bins: Mapping[str, tuple[Names, ...]]


class Baseline(Record, frozen=True, kw_only=True):
    """What the suites of a testbench reached."""

    schema: Literal["hricdv-baseline/1"]
    testbench: str
    suites: Mapping[str, SuiteBaseline]


def baseline_of(report: Report, old: Baseline | None = None) -> Baseline:
    """What to keep of a report. Suites that the old baseline has and the report has not are kept as they are."""
    percents = {kind: dict(percentages(report, kind)) for kind in KINDS}
    now = {
        suite.name: _suite_baseline(
            suite,
            [test for test in report.tests if test.suite == suite.name],
            {kind: percents[kind].get(suite.name) for kind in KINDS},
        )
        for suite in report.suites
    }
    return Baseline(schema=SCHEMA, testbench=report.testbench, suites={**(old.suites if old else {}), **now})


def _suite_baseline(
    suite: SuiteResult, tests: Sequence[TestResult], percent: Mapping[str, float | None]
) -> SuiteBaseline:
    return SuiteBaseline(
        violations={requirement: _violating(tests, requirement) for requirement in suite.requirements},
        broken=tuple(sorted(test.id for test in tests if test.outcome == "error")),
        triggers={requirement: tally.triggers for requirement, tally in suite.requirements.items()},
        percent=percent,
        plans={agent: tuple(sorted(plans.covered)) for agent, plans in suite.plans.items()},
        bins={name: tuple(sorted(hit.bin for hit in product.hits)) for name, product in suite.cross.products.items()},
    )


def _violating(tests: Sequence[TestResult], requirement: str) -> Names:
    return tuple(sorted(test.id for test in tests if test.requirements[requirement].verdict == "Failed"))


def read_baseline(path: Path, testbench: str) -> Baseline:
    """Read a baseline.

    Raises:
        BaselineError: it is missing, cut off, no baseline, or one of another testbench.
    """
    try:
        baseline = decode_located(path.read_text(encoding="utf-8"), Baseline)
    except FileNotFoundError:
        raise BaselineError(f"{path}: no such baseline; write it with --hri-update-baseline") from None
    except MalformedError as error:
        raise BaselineError(f"{path}{error}") from None
    except (OSError, UnicodeDecodeError) as error:
        raise BaselineError(f"{path}: cannot be read: {error}") from None
    if baseline.testbench != testbench:
        raise BaselineError(f"{path}: of the testbench {baseline.testbench!r}; expected {testbench!r}")
    return baseline


def write_baseline(baseline: Baseline, path: Path) -> None:
    """Write a baseline atomically, a line for each value, so that a version control system shows what changed.

    Raises:
        BaselineError: the folder cannot be written.
    """
    text = json.dumps(to_builtins(baseline), sort_keys=True, indent=1, allow_nan=False)
    try:
        write_text(path, text + "\n")
    except OSError as error:
        raise BaselineError(f"{path}: cannot be written: {error.strerror or error}") from None
