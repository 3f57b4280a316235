"""Compares the behaviour of tests with a baseline: which tests differ, and the first difference of each.

`GateCheck` and `hricdv report gate` call `compare_behaviour` before the gates are judged; mutation testing compares one
test by `change_of`. Views show the `headline`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from msgspec.structs import replace

from pytest_hricdv._base.hash_seed import hash_seed_difference
from pytest_hricdv.results.baseline import (
    Baseline,
    SuiteBaseline,
    baseline_of,
    behaviour_of,
    environment_of,
    hash_seed,
)
from pytest_hricdv.results.behaviour import Behaviour, BehaviourChange, BehaviourChanges, ChangeKind
from pytest_hricdv.results.first_difference import end_differences, first_difference
from pytest_hricdv.results.model import Report, SuiteResult, TestResult
from pytest_hricdv.results.section import failure_causes


def compare_behaviour(report: Report, baseline: Baseline, *, whole: bool) -> BehaviourChanges:
    """Compare what each test of a report did with a baseline. Tests that were not run are left out.

    Args:
        whole: whether all tests of the suites were selected.
    """
    suites = {suite.name: baseline.suites.get(suite.name) for suite in report.suites}
    run = [test for test in report.tests if test.outcome != "not-run"]
    pairs = [(test, _before(suites.get(test.suite), test)) for test in run]
    compared = [(test, before) for test, before in pairs if before is not None]
    changes = {test.nodeid: change_of(before, behaviour_of(test)) for test, before in compared}
    changed = {nodeid: change for nodeid, change in changes.items() if change is not None}
    return BehaviourChanges(
        compared=len(compared),
        changed=changed,
        kinds=_kinds(changed),
        new=tuple(test.id for test, before in pairs if before is None and _has_behaviour(suites.get(test.suite))),
        removed=tuple(_list_removed_tests(report, suites)) if whole else (),
        notes=tuple(dict.fromkeys(_notes(report, suites, changed=bool(changed)))),
    )


def compare_with_session_before(report: Report, before: Report, *, whole: bool) -> BehaviourChanges | None:
    """Compare what each test did with the session before; None where nothing changed, or nothing can be compared.

    Tests that were not run then, as of a session that was interrupted and is resumed, are left out.

    Args:
        whole: whether all tests of the suites were selected: a cause that none of them fails for is gone.
    """
    seeds = {suite.name: suite.seed for suite in report.suites}
    suites = tuple(suite for suite in before.suites if seeds.get(suite.name) == suite.seed)
    tests = tuple(test for test in before.tests if test.outcome != "not-run")
    records = {test.nodeid: test.record_sha256 for test in tests}
    same = all(records.get(test.nodeid, test.record_sha256) == test.record_sha256 for test in report.tests)
    if same or before.testbench != report.testbench:
        return None
    changes = compare_behaviour(report, baseline_of(replace(before, suites=suites, tests=tests)), whole=False)
    if not changes.changed:
        return None
    causes = tuple(_list_cause_changes(report, before, whole=whole and not before.not_run))
    return replace(changes, against="session before", new=(), notes=(*causes, *changes.notes))


def _list_cause_changes(report: Report, before: Report, *, whole: bool) -> Iterator[str]:
    """The causes that the session before did not have, and of whole sessions those that are gone."""
    now, old = failure_causes(report), failure_causes(before)
    if now is None or old is None:
        return
    yield from (f"new cause {name}: {words}" for name, words in now.items() if name not in old)
    if whole:
        yield from (f"cause {name} is gone: {words}" for name, words in old.items() if name not in now)


def _has_behaviour(suite: SuiteBaseline | None) -> bool:
    """Whether a test that it lacks is new: what an older version wrote lacks all tests."""
    return suite is None or suite.tests is not None


def _before(suite: SuiteBaseline | None, test: TestResult) -> Behaviour | None:
    tests = (suite.tests if suite else None) or {}
    return tests.get(test.nodeid) or tests.get(test.id)


def headline(changes: BehaviourChanges) -> str:
    """`12 of 134 tests behave differently from the baseline`, or from the session before."""
    count = len(changes.changed)
    if not changes.compared:
        return f"the behaviour of no test was compared with the {changes.against}"
    if not count:
        return f"all {changes.compared} tests behave as in the {changes.against}"
    return f"{count} of {changes.compared} tests behave{'s' * (count == 1)} differently from the {changes.against}"


def change_of(before: Behaviour, now: Behaviour) -> BehaviourChange | None:
    """The change between two runs of a test; None if their records are bit-identical and their ends are equal."""
    if before.record_sha256 == now.record_sha256 and not any(end_differences(before, now)):
        return None
    first = first_difference(before, now)
    return BehaviourChange(
        kind=first.kind,
        text=first.text,
        time_s=first.time_s,
        topic=first.topic,
        also=tuple(_also(before, now)),
        before=before,
    )


def _also(before: Behaviour, now: Behaviour) -> Iterator[str]:
    """The consequences of the first difference: the end, outcomes, faults, verdicts, margins."""
    yield from (text for _, text in end_differences(before, now))
    for name, (verdict, margin) in now.verdicts.items():
        old_verdict, old_margin = before.verdicts.get(name, ("", None))
        if old_verdict and verdict != old_verdict:
            yield f"{name} {verdict} instead of {old_verdict}"
        elif margin != old_margin and None not in (margin, old_margin):
            yield f"margin of {name} {margin:.4g} instead of {old_margin:.4g}"


def _kinds(changed: Mapping[str, BehaviourChange]) -> tuple[ChangeKind, ...]:
    by_kind: dict[str, list[str]] = {}
    for nodeid in sorted(changed, key=lambda nodeid: (changed[nodeid].time_s or 0.0, nodeid)):
        by_kind.setdefault(changed[nodeid].kind, []).append(nodeid)
    kinds = [ChangeKind(kind=kind, tests=len(nodeids), example=nodeids[0]) for kind, nodeids in by_kind.items()]
    return tuple(sorted(kinds, key=lambda kind: (-kind.tests, kind.kind)))


def _list_removed_tests(report: Report, suites: Mapping[str, SuiteBaseline | None]) -> Iterator[str]:
    present = {name for test in report.tests for name in (test.id, test.nodeid)}
    for before in suites.values():
        yield from sorted(name for name in (before and before.tests) or () if name not in present)


def _notes(report: Report, suites: Mapping[str, SuiteBaseline | None], *, changed: bool) -> Iterator[str]:
    for suite in report.suites:
        before = suites[suite.name]
        if before is None:
            continue
        if before.tests is None:
            yield (
                f"the baseline has no behaviour of suite {suite.name}, because an older version wrote it: "
                "--hri-update-baseline adds it"
            )
        elif changed:
            yield from _causes(before, report, suite)
        elif before.code_sha256 != report.code_under_test.sha256:
            yield "the code under test has changed, but no test behaves differently"


def _causes(before: SuiteBaseline, report: Report, suite: SuiteResult) -> Iterator[str]:
    """Possible causes of the changed behaviour other than the code under test."""
    for name, version in environment_of(report, suite).items():
        old = before.environment.get(name, version)
        if old != version:
            yield f"{name} was {old} before, and is {version} now: records may differ for that"
    other_seed = hash_seed_difference(before.hash_seed, hash_seed(report))
    if other_seed:
        yield (
            f"Python's hash seed differs from the one before ({other_seed}), so code iterates over sets in another "
            f"order; set PYTHONHASHSEED={before.hash_seed if before.hash_seed.isdigit() else '0'} for both"
        )
    if before.code_sha256 == report.code_under_test.sha256:
        yield (
            "the code under test is the same as before, so the testbench, its world, the model or a library "
            f"has changed, {'if it is not the hash seed, ' if other_seed else ''}or runs depend on something that "
            "changes each time, such as a clock"
        )
