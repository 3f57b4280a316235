"""The `Baseline`: the results of an earlier session, kept under version control to find what got worse.

`GateCheck` and `hricdv report gate` read and write its file. `baseline_of` makes the baseline of a report, which
`gate_check` and `behaviour_diff` compare with an earlier one.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final, Literal
from zlib import crc32  # as now: the code under test may replace them

from msgspec import to_builtins
from msgspec.structs import asdict

from pytest_hricdv._base import own_json as json
from pytest_hricdv._base.atomic_file import write_text
from pytest_hricdv._base.hash_seed import SEVERAL
from pytest_hricdv._base.input_file import MAX_REPORT_BYTES, MalformedError, check_plain, from_json, read_text
from pytest_hricdv._base.message import InputError, quote
from pytest_hricdv._base.record import Count, Names, Number, PlainRecord
from pytest_hricdv.results.behaviour import Behaviour, BusMessage
from pytest_hricdv.results.codec import ReportError, canonical
from pytest_hricdv.results.derivation import percentages
from pytest_hricdv.results.gates import KINDS
from pytest_hricdv.results.model import Report, SuiteResult, TestResult
from pytest_hricdv.results.section import failure_causes

SCHEMA: Final = "hricdv-baseline/2"


class BaselineError(InputError):
    """A baseline cannot be read, written or compared with; the message says which file, why, and what to do."""


class SuiteBaseline(PlainRecord, frozen=True, kw_only=True):
    """The results of one suite: violating tests by requirement, tests in error or at fault, triggers, coverage.

    A baseline that an older version of the plugin wrote has none of the fields with a default.

    Args:
        seed: the seed that the suite was generated from.
        code_sha256: SHA-256 of the code under test.
        environment: name -> version of everything besides code and testbench that a record can depend on.
        tests: test -> what it did; a test is its id, or its node id where several test functions ran it.
        hash_seed: see `ReportOrigin`.
        causes: why tests fail, except known violations: id -> words; None if nobody looked for it.
    """

    violations: Mapping[str, Names]
    broken: Names
    triggers: Mapping[str, Count]
    percent: Mapping[str, Number | None]
    plans: Mapping[str, Names]
    bins: Mapping[str, tuple[Names, ...]]
    seed: int | None = None
    code_sha256: str = ""
    environment: Mapping[str, str] = {}
    tests: Mapping[str, Behaviour] | None = None
    hash_seed: str = ""
    causes: Mapping[str, str] | None = None


class Baseline(PlainRecord, frozen=True, kw_only=True):
    """The results of a testbench's suites."""

    schema: Literal["hricdv-baseline/2"]
    testbench: str
    suites: Mapping[str, SuiteBaseline]


def baseline_of(report: Report, old: Baseline | None = None) -> Baseline:
    """The baseline of a report. Suites that only the old baseline has are kept."""
    percents = {kind: dict(percentages(report, kind)) for kind in KINDS}
    now = {
        suite.name: _suite_baseline(report, suite, {kind: percents[kind].get(suite.name) for kind in KINDS})
        for suite in report.suites
    }
    return Baseline(schema=SCHEMA, testbench=report.testbench, suites={**(old.suites if old else {}), **now})


def _suite_baseline(report: Report, suite: SuiteResult, percent: Mapping[str, float | None]) -> SuiteBaseline:
    tests = [test for test in report.tests if test.suite == suite.name]
    return SuiteBaseline(
        violations={requirement: _violation_ids(tests, requirement) for requirement in suite.requirements},
        broken=tuple(sorted(test.id for test in tests if test.outcome == "error" or test.errors)),
        triggers={requirement: tally.triggers for requirement, tally in suite.requirements.items()},
        percent=percent,
        plans={agent: tuple(sorted(plans.covered)) for agent, plans in suite.plans.items()},
        bins={name: tuple(sorted(hit.bin for hit in product.hits)) for name, product in suite.cross.products.items()},
        seed=suite.seed,
        code_sha256=report.code_under_test.sha256,
        environment=environment_of(report, suite),
        tests=_behaviours(tests),
        hash_seed=hash_seed(report),
        causes=failure_causes(report, suite.name),
    )


def hash_seed(report: Report) -> str:
    """The hash seed of the processes that ran a report's tests, also of the sessions that it is merged from."""
    origins = [report.origin] if report.origin else [session.origin for session in report.sessions]
    seeds = {origin.hash_seed if origin else "" for origin in origins}
    return seeds.pop() if len(seeds) == 1 else SEVERAL if seeds else ""


def environment_of(report: Report, suite: SuiteResult) -> dict[str, str]:
    """Name -> version, of what the records of a suite's tests can depend on besides code and testbench."""
    simulation = {"fidelity": suite.fidelity, "engine": suite.engine}
    return {**report.environment, **{name: value for name, value in simulation.items() if value}}


def _behaviours(tests: Sequence[TestResult]) -> dict[str, Behaviour]:
    uses = Counter(test.id for test in tests)
    return {test.id if uses[test.id] == 1 else test.nodeid: behaviour_of(test) for test in tests}


def behaviour_of(test: TestResult) -> Behaviour:
    """The behaviour of a test's run to keep. Raises ReportError for a timeline that is none."""
    timeline = test.timeline
    return Behaviour(
        record_sha256=test.record_sha256,
        parameters=f"{crc32(canonical(test.concrete).encode('ascii')):08x}",
        end_reason=test.end_reason,
        end_s=timeline.end_s if timeline else 0.0,
        outcomes=test.outcomes,
        messages=tuple(map(_message, timeline.messages)) if timeline else (),
        signals=timeline.checksums if timeline else {},
        verdicts={
            name: (result.verdict, None if result.margin is None else float(f"{result.margin:.6g}"))
            for name, result in test.requirements.items()
        },
        errors=test.errors,
    )


def _message(text: str) -> BusMessage:
    """A message of a timeline. JSON has no NaN or infinity: as a field's value they become text.

    A lone surrogate, which has no UTF-8, becomes a question mark: a file with it could not be read again.
    """
    try:
        time_s, sender, topic, text_of_fields = text.split("\t", 3)
        fields = json.loads(text_of_fields, parse_constant=str)
        if "\\ud" in text_of_fields:
            fields = json.loads(json.dumps(fields, ensure_ascii=False).encode("utf-8", "replace"))
        check_plain([at_s := json.loads(time_s), fields])
        if not isinstance(at_s, int | float) or not isinstance(fields, dict):
            raise ValueError
        return BusMessage(at_s, sender, topic, fields)
    except (ValueError, RecursionError):
        raise ReportError(
            f"message {quote(text)} of a timeline: expected time, sender, topic and fields as JSON, between tabs"
        ) from None


def _violation_ids(tests: Sequence[TestResult], requirement: str) -> Names:
    return tuple(sorted(test.id for test in tests if test.violates(requirement)))


def read_baseline(path: Path, testbench: str) -> Baseline:
    """Read a baseline.

    Raises:
        BaselineError: it is missing, cut off, no baseline, or one of another testbench.
    """
    try:
        baseline = from_json(read_text(path, MAX_REPORT_BYTES), Baseline, strict=True)
        for suite in baseline.suites.values():
            for behaviour in (suite.tests or {}).values():
                for message in behaviour.messages:
                    check_plain(message.fields)  # a message may have any fields
    except FileNotFoundError:
        raise BaselineError(f"{path}: no such baseline; write it with --hri-update-baseline") from None
    except MalformedError as error:
        raise BaselineError(f"{path}{error}; update it with --hri-update-baseline") from None
    if baseline.testbench != testbench:
        raise BaselineError(f"{path}: of the testbench {baseline.testbench!r}; expected {testbench!r}")
    return baseline


def check_suites(baseline: Baseline, seeds: Mapping[str, int], where: str, *, behaviour: bool) -> None:
    """Check that a baseline can be compared with a run.

    Args:
        baseline: the baseline to compare with.
        seeds: suite -> seed, of the run.
        where: the baseline's file, for errors.
        behaviour: whether the behaviour of the tests has to be compared, not only what they reached.

    Raises:
        BaselineError: it has none of the run's suites, or one of another seed or without the behaviour of its tests.
    """
    common = {name: baseline.suites[name] for name in seeds if name in baseline.suites}
    if seeds and not common:
        raise BaselineError(
            f"{where}: of the suite {', '.join(sorted(baseline.suites)) or 'none'}; this run has {', '.join(seeds)}: "
            "choose the baseline's suite, add this one to the baseline with --hri-update-baseline, or compare with "
            "none (--hri-baseline=)"
        )
    for name, before in common.items():
        if before.seed is not None and before.seed != seeds[name]:
            raise BaselineError(
                f"{where}: of suite {name} with seed {before.seed}; this run has seed {seeds[name]}, so other tests: "
                f"run it with seed {before.seed}, update the baseline with --hri-update-baseline, or compare with "
                "none (--hri-baseline=)"
            )
        if behaviour and before.tests is None:
            raise BaselineError(
                f"{where}: an older version wrote it, without the behaviour of suite {name}, which "
                "--hri-fail-on-change compares: update it with --hri-update-baseline"
            )


def write_baseline(baseline: Baseline, path: Path) -> None:
    """Write a baseline atomically: a line for each value, and one for each test's behaviour.

    So a version control system shows what changed.

    Raises:
        BaselineError: the folder cannot be written.
    """
    try:
        write_text(path, _lines(baseline) + "\n")
    except OSError as error:
        raise BaselineError(f"{path}: cannot be written: {error.strerror or error}") from None


def _lines(value: object, indent: str = "\n") -> str:
    """JSON with sorted keys; what is None in a record is left out."""
    inner = f"{indent} "
    if isinstance(value, PlainRecord) and not isinstance(value, Behaviour):
        value = {name: item for name, item in asdict(value).items() if item is not None}
    if isinstance(value, Mapping) and value:
        items = [f"{json.dumps(key)}: {_lines(value[key], inner)}" for key in sorted(value)]
        return f"{{{inner}{f',{inner}'.join(items)}{indent}}}"
    if isinstance(value, tuple) and value:
        return f"[{inner}{f',{inner}'.join(_lines(item, inner) for item in value)}{indent}]"
    return json.dumps(to_builtins(value), sort_keys=True, separators=(",", ":"), allow_nan=False)
