"""`merge`: unites reports of shards of a suite, of other suites, or of repeated runs, for `hricdv report merge`.

A merge is a union of tests, and all that follows from the tests is computed again by `derive`. So it is commutative,
associative and idempotent: the same reports give the same bytes, in any order and however often they are given.

A test that several reports have counts once. Where they disagree (the same node id and seed, another run), the worst
run stands for the test, and the others are kept in its `repeats`; what any of them covered is covered.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from hashlib import sha256

from msgspec.structs import replace

from pytest_hricdv._base.message import InputError
from pytest_hricdv.coverage.code_map import CoverageError
from pytest_hricdv.coverage.records import CodeShare
from pytest_hricdv.execution.outcome import OUTCOMES
from pytest_hricdv.registry import offers
from pytest_hricdv.results.codec import canonical
from pytest_hricdv.results.derivation import declare_suite, derive
from pytest_hricdv.results.model import GatePolicy, Report, RerunOptions, SessionSummary, SuiteResult, TestResult
from pytest_hricdv.results.origin import GenerationResult
from pytest_hricdv.results.section import report_sections, test_sections

_EQUAL = (
    *("version", "testbench", "requirements", "state", "outcome_label"),
    *("known_violations", "known_when", "known_until", "allowed_untriggered", "strict"),
)


class MergeError(InputError):
    """Reports that do not belong together; the message says which, in what they differ, and what to do."""


def merge(reports: Sequence[tuple[str, Report]]) -> Report:
    """Merge several reports into one.

    Args:
        reports: each with what to call it in errors.

    Raises:
        MergeError: there is none, or they are of different code, testbenches, requirements, models or suites.
    """
    if not reports:
        raise MergeError("nothing to merge: expected at least one report")
    first_name, first = reports[0]
    for name, report in reports[1:]:
        _refuse_others(first_name, first, name, report)
    all_reports = [report for _, report in reports]
    sessions = _sessions(all_reports)
    reasons = sorted({report.code_under_test.reason for report in all_reports} - {""})
    merged = replace(
        first,
        code_under_test=replace(first.code_under_test, reason=reasons[0] if reasons else ""),
        wall_s=round(math.fsum(session.wall_s for session in sessions), 3),
        workers=max(session.workers for session in sessions),
        rerun_options=_rerun(all_reports),
        sessions=sessions,
        exploration=max((report.exploration for report in all_reports), key=canonical),
        models=max((report.models for report in all_reports), key=canonical),
        suites=_suites(reports),
        tests=_tests(all_reports),
        units=first.units if all(report.units == first.units for report in all_reports) else None,
        shard="",
        gates=None,
        policy=_policy(all_reports),
        problems=tuple(sorted({problem for report in all_reports for problem in report.problems})),
        origin=None,  # that of each session is in `sessions`
        full_report="",
        environment=dict(set.intersection(*(set(report.environment.items()) for report in all_reports))),
        changes=None,
    )
    try:
        merged = derive(merged)
    except CoverageError as error:
        raise MergeError(f"the merged report is wrong: {error}") from None
    for section in report_sections():
        merged = section.put(merged, section.default)
    for merge_part in offers("merging", "merge"):
        merged = merge_part(all_reports, merged)
    return merged


def count_expected(report: Report) -> int:
    """How many tests a merged report should have: of shards all tests of their suites, else those that it lists."""
    if any(session.shard for session in report.sessions):
        return max(report.selected, sum(suite.size for suite in report.suites))
    return report.selected


def list_missing_shards(report: Report) -> tuple[str, ...]:
    """The shards without a session, as `2/3`; of sessions with different numbers of shards, of the most."""
    if not report.sessions or any(not session.shard for session in report.sessions):
        return ()
    shards = [tuple(map(int, session.shard.split("/"))) for session in report.sessions]
    of = max(shard[1] for shard in shards)
    present = {shard[0] for shard in shards if shard[1] == of}
    return tuple(f"{index}/{of}" for index in range(1, of + 1) if index not in present)


def _refuse_others(first_name: str, first: Report, name: str, report: Report) -> None:
    both = f"{first_name} and {name}"
    for key in _EQUAL:
        if getattr(first, key) != getattr(report, key):
            raise MergeError(f"{both}: different {key.replace('_', ' ')}: {_difference(first, report, key)}")
    if first.code_under_test.sha256 != report.code_under_test.sha256:
        raise MergeError(f"{both}: different code under test: {_files_that_differ(first, report)}; run both again")
    if first.cross_products != report.cross_products:
        raise MergeError(f"{both}: the testbench declared different cross products; run both again")
    if first.models and report.models and first.models != report.models:
        raise MergeError(f"{both}: different BDI models; run both again")


def _difference(first: Report, report: Report, key: str) -> str:
    value, other = getattr(first, key), getattr(report, key)
    if isinstance(value, dict) and isinstance(other, dict):
        return ", ".join(_unequal_keys(value, other))
    return f"{value!r} and {other!r}"


def _files_that_differ(first: Report, report: Report) -> str:
    files, others = ({file.file: file for file in merged.code_under_test.map} for merged in (first, report))
    return ", ".join(_unequal_keys(files, others)) or "one of them does not say which"


def _unequal_keys(values: Mapping[str, object], others: Mapping[str, object]) -> list[str]:
    return sorted(name for name in values.keys() | others.keys() if values.get(name) != others.get(name))


def sessions_of(report: Report) -> tuple[SessionSummary, ...]:
    """The sessions that a report is of: its own, or, of a merged one, those that it was merged from."""
    if report.sessions:
        return report.sessions
    session = SessionSummary(
        sha256=sha256(canonical(report).encode("ascii")).hexdigest(),
        wall_s=report.wall_s,
        workers=report.workers,
        selected=report.selected,
        reported=report.reported,
        shard=report.shard,
        origin=report.origin,
    )
    return (session,)


def _sessions(reports: Iterable[Report]) -> tuple[SessionSummary, ...]:
    """The sessions of all reports; two reports with the same content are one session."""
    by_content = {session.sha256: session for report in reports for session in sessions_of(report)}
    return tuple(by_content[sha256] for sha256 in sorted(by_content))


def _rerun(reports: Iterable[Report]) -> RerunOptions:
    reruns = [report.rerun_options for report in reports]
    suites = {name for rerun in reruns for name in rerun.suite.split(",")} - {""}
    options = {option for rerun in reruns for option in rerun.options}
    return RerunOptions(suite=",".join(sorted(suites)), options=tuple(sorted(options)))


def _policy(reports: Iterable[Report]) -> GatePolicy | None:
    """The union of the sessions' policies on what to keep."""
    policies = [report.policy for report in reports if report.policy is not None]
    if not policies:
        return None
    thresholds: dict[str, float] = {}
    for policy in policies:
        for kind, percent in policy.thresholds.items():
            thresholds[kind] = max(percent, thresholds.get(kind, 0.0))
    return GatePolicy(
        thresholds=dict(sorted(thresholds.items())),
        fail_on_nc=any(policy.fail_on_nc for policy in policies),
        fail_on_change=any(policy.fail_on_change for policy in policies),
        fail_on_pending=any(policy.fail_on_pending for policy in policies),
    )


def _suites(reports: Sequence[tuple[str, Report]]) -> tuple[SuiteResult, ...]:
    suites: dict[str, tuple[str, SuiteResult]] = {}
    for where, report in reports:
        for suite in report.suites:
            plans = {agent: plans.declared for agent, plans in suite.plans.items()}
            declared = declare_suite(suite.name, suite.seed, suite.size, suite.generation, plans)
            before = suites.get(suite.name)
            suites[suite.name] = (where, _same_suite(*before, where, declared) if before else declared)
    return tuple(suites[name][1] for name in sorted(suites))


def _same_suite(where: str, suite: SuiteResult, there: str, other: SuiteResult) -> SuiteResult:
    timeless = [replace(result, generation=_timeless(result.generation)) for result in (suite, other)]
    if timeless[0] != timeless[1]:
        difference = "another seed" if suite.seed != other.seed else "other tests or options"
        raise MergeError(
            f"{where} and {there}: two suites have the name {suite.name!r} but {difference}; merge runs of one and "
            "the same suite, or rename one"
        )
    return min(suite, other, key=lambda result: (-result.generation.wall_s, canonical(result)))


def _timeless(generation: GenerationResult) -> GenerationResult:
    return replace(generation, wall_s=0, cached=False)


def _tests(reports: Iterable[Report]) -> tuple[TestResult, ...]:
    runs: dict[str, dict[str, TestResult]] = {}
    for report in reports:
        for test in report.tests:
            for run in test.runs:
                alone = replace(run, repeats=())
                same_test = runs.setdefault(run.nodeid, {})
                key = _content(alone)
                same_test[key] = _unite(same_test[key], alone) if key in same_test else alone
    return tuple(_with_repeats([*same_test.values()]) for same_test in runs.values())


def _content(run: TestResult) -> str:
    """Equal for two runs exactly where everything is that a run determines: verdicts, record, plans, bins.

    Left out is what can differ between two reports of one run; `_unite` decides about each of these fields.
    """
    same = replace(
        run,
        wall_s=None,
        code=None,
        failure="",
        unmeasured="",
        replay=None,
        replayed=None,
        **{section.name: section.default for section in test_sections() if not section.identifies},
    )
    return canonical(same)


def _unite(run: TestResult, other: TestResult) -> TestResult:
    """Unite two reports of one run: the shorter time, all measurements, the first texts and files by content."""
    times = [result.wall_s for result in (run, other) if result.wall_s is not None]
    return replace(
        run,
        wall_s=min(times, default=None),
        code=_most_measured(run.code, other.code),
        **{name: _first(getattr(run, name), getattr(other, name)) for name in (*_ANY_OF, *_any_of_parts())},
    )


_ANY_OF = ("failure", "unmeasured", "replay", "replayed")


def _any_of_parts() -> Iterator[str]:
    return (section.name for section in test_sections() if not section.identifies)


def _first(value: object, other: object) -> object:
    """The first of two values by content; an empty one only where both are."""
    return min(filter(None, (value, other)), key=_text, default=value)


def _text(value: object) -> str:
    return canonical({"value": value})


def _most_measured(share: CodeShare | None, other: CodeShare | None) -> CodeShare | None:
    """The run's coverage, from the report that measured most of it."""
    measured = [code for code in (share, other) if code is not None]
    return max(measured, key=lambda code: (code.bits[1] is not None, code.statements, canonical(code)), default=None)


def _with_repeats(runs: list[TestResult]) -> TestResult:
    """The worst run, with the others; a missing run stands for a test only if there is no other."""
    done = [run for run in runs if run.outcome != "not-run"] or runs[:]
    done.sort(key=lambda run: (OUTCOMES.index(run.outcome), _text(run)))
    if done[0].outcome == "not-run":
        done = done[:1]
    return replace(done[0], repeats=tuple(done[1:]))
