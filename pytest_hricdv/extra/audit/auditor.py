"""`Auditor`: chooses tests of a session, reruns them, finds out why some give other results, and marks those.

`AuditFeature` uses it after the last test. A `Repeater` reruns the tests, a `CauseSearch` finds causes.
"""

from __future__ import annotations

import os
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from itertools import zip_longest
from pathlib import Path

import msgspec

from pytest_hricdv.extra.audit.diagnosis import NOT_FOUND, CauseSearch, RepeatCause
from pytest_hricdv.extra.audit.process import RerunAnswer, RerunOrder, key_of
from pytest_hricdv.extra.audit.records import AUDIT, UNREPEATABLE, AuditResult, Unrepeatable, sentence
from pytest_hricdv.extra.audit.repeating import Begin, Repeater, Start, StartError
from pytest_hricdv.results.codec import encode
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.results.report_builder import UNCHECKED
from pytest_hricdv.results.timeline import differing_events
from pytest_hricdv.runtime.supervision import took_long
from pytest_hricdv.session.aggregation import TestTimes
from pytest_hricdv.session.child_process import FreshSession, drop_editor_plugin, make_worker_input, session_arguments
from pytest_hricdv.session.feature import FeatureSession

EXPERIMENTS_S = 120.0
"""Time (s of wall time since the audit began) after which no experiment on causes starts; after longer sessions, it is
the time that the session took. Enough for some twenty processes of a few seconds (`benchmarks.isolation`)."""

MAX_FURTHER = 10
"""Maximum number of other failed tests to rerun after one was not repeatable: a session may have hundreds."""

_LEFT_OUT = frozenset({".git", ".hg", ".tox", ".nox", ".venv", "venv", "node_modules", "__pycache__", ".pytest_cache"})
"""Folders that contain no data of tests, so their files are not compared."""

_MAX_FILES = 20_000
"""Maximum number of files of a project that are compared, which takes a second at most."""


class Auditor:
    """Audits a session.

    Args:
        session: the session that has run its tests.
        number: number of tests to rerun; None: as many as cost little.
        begin: what the session was like before its first test.
    """

    def __init__(self, session: FeatureSession, number: int | None, begin: Begin) -> None:
        self._session = session
        self._number = number
        self._config = session.context.collection.config
        self._began_s = time.monotonic()
        own = session.aggregation.hash_seed
        self._session_seed = own if own.isdigit() else ""
        self._hash_seed = "2" if own == "1" else "1"
        collection = session.context.collection
        self._start = Start(
            FreshSession(
                drop_editor_plugin(session_arguments(self._config)),
                make_worker_input(self._config, collection.worker_values()),
                (),
            ),
            self._config.invocation_params.dir,
            begin,
            reusable=hasattr(os, "fork"),
        )

    def audit(self, results: list[TestResult]) -> list[TestResult]:
        """The results, with those marked that gave another result; what was run again is added to the report."""
        before = self._take_over(results)
        place = {nodeid: number for ran in self._processes for number, nodeid in enumerate(ran) if nodeid not in before}
        tests = choose_tests(results, place, self._number)
        if not tests:
            self._keep(AuditResult(differing=before))
            return results
        changed = dict(self._files_of_tests())  # before the first of them runs again, and changes it
        wall_s = {result.nodeid: result.wall_s or 0.0 for result in results}
        further = [result for result in results if result.fails and result.nodeid in place and result not in tests]
        further = further[:MAX_FURTHER] if self._number is None else []
        start = self._start.with_tests([test.nodeid for test in (*tests, *further)])
        repeating, problem = Repeater(start, wall_s, self._session.signals.let_through), ""
        differing, marked = dict[str, tuple[TestResult, RerunAnswer]](), dict[str, TestResult]()
        try:
            with repeating.open():
                self._compare(repeating, tests, differing)
                if differing:
                    self._compare(repeating, further, differing)
                for nodeid, (result, repeat) in differing.items():
                    marked[nodeid] = self._mark(result, repeat, self._cause(repeating, result, repeat, changed))
        except StartError as error:
            problem = f"the audit could not run tests again in a fresh process: {error}"
            self._session.warnings.append(problem)
        except KeyboardInterrupt:
            self._session.interrupted, problem = True, "the audit was interrupted"
            for nodeid in [name for name in differing if name not in marked]:
                marked[nodeid] = self._mark(*differing[nodeid], RepeatCause(NOT_FOUND, problem))
        self._keep(
            AuditResult(
                tests=tuple(test.nodeid for test in tests),
                differing=(*before, *marked),
                hash_seed=self._hash_seed,
                session_hash_seed=self._session.aggregation.hash_seed,
                runs=repeating.runs,
                wall_s=round(time.monotonic() - self._began_s, 3),
                problem=problem,
            )
        )
        for nodeid, result in marked.items():
            self._session.aggregation.journaling.finish(nodeid, encode(result))
        return [marked.get(result.nodeid, result) for result in results]

    def _keep(self, result: AuditResult) -> None:
        """Add to the report what was audited."""
        session = self._session
        session.sections[AUDIT.name] = result
        session.done.update(() if session.interrupted else [AUDIT.name])

    def _take_over(self, results: Sequence[TestResult]) -> tuple[str, ...]:
        """The tests with another result in the session that this one resumes; they fail it, too."""
        marks = {result.nodeid: (result.id, UNREPEATABLE.of(result)) for result in results}
        found = {nodeid: f"{name} {sentence(mark)}" for nodeid, (name, mark) in marks.items() if mark is not None}
        self._session.problems += found.values()
        return tuple(found)

    @cached_property
    def _processes(self) -> list[list[str]]:
        """The tests of each process, in order. Of a session that was killed only the order of all is known: what its
        tests left to each other is found by experiment."""
        aggregation = self._session.aggregation
        resumed, here = aggregation.journaling.resumed, [[*ran] for ran in aggregation.ran.values()]
        ran_here = {nodeid for ran in here for nodeid in ran}
        earlier = [] if resumed is None else [nodeid for nodeid in resumed.results if nodeid not in ran_here]
        return [earlier, *here] if earlier else here

    def _compare(
        self, repeating: Repeater, tests: Sequence[TestResult], differing: dict[str, tuple[TestResult, RerunAnswer]]
    ) -> None:
        """Rerun tests; tests with a different result are added."""
        tell = self._session.wait("rerunning tests, to check that they are repeatable")
        for number, test in enumerate(tests, 1):
            tell(f"{number} of {len(tests)}")
            repeat = repeating.run(RerunOrder((test.nodeid,)), self._hash_seed)
            if repeat.key != key_of(test):
                differing[test.nodeid] = test, repeat

    def _cause(
        self, repeating: Repeater, result: TestResult, repeat: RerunAnswer, changed: Mapping[str, str]
    ) -> RepeatCause:
        aggregation = self._session.aggregation
        took_s = sum(test.wall_s or 0.0 for test in self._session.results)
        self._session.say(f"hricdv: {result.id} gave another result when rerun; looking for the cause ...")
        processes = [] if self._session.options.isolate else self._processes
        diagnosis = CauseSearch(
            repeating,
            result.nodeid,
            key_of(result),
            repeat,
            hash_seed=self._hash_seed,
            session_seed=self._session_seed,
            in_process=next((ran for ran in processes if result.nodeid in ran), []),
            changed=changed,
            was_in_worker=aggregation.is_distributed,
            until_s=self._began_s + max(EXPERIMENTS_S, took_s),
        )
        try:
            return diagnosis.cause()
        except StartError as error:
            return RepeatCause(NOT_FOUND, str(error))

    def _mark(self, result: TestResult, repeat: RerunAnswer, cause: RepeatCause) -> TestResult:
        """The result with its mark; a failure that does not occur alone is not a violation."""
        again = repeat.result
        here, there = differing_events(result, again)
        if again is None:
            there = repeat.problem
        unconfirmed = result.fails and (again is None or not again.fails or _violations(again) != _violations(result))
        record = Unrepeatable(
            cause=cause.name,
            detail=cause.detail,
            left_by=cause.left_by,
            outcome=result.outcome,
            outcome_alone="none" if again is None else again.outcome,
            in_session=here,
            alone=there,
            hash_seed=self._hash_seed,
            is_violation_unconfirmed=unconfirmed,
        )
        self._session.problems.append(f"{result.id} {sentence(record)}")
        result = UNREPEATABLE.put(result, record)
        if not unconfirmed:
            return result
        return msgspec.structs.replace(
            result,
            outcome="error",
            requirements=dict.fromkeys(result.requirements, UNCHECKED),
            errors=(),
            failure=f"{sentence(record)}\n\nin the session:\n{result.failure}",
        )

    def _files_of_tests(self) -> Iterator[tuple[str, str]]:
        """Files of the project that were written since the first test began, and the test that ran then."""
        runs = [ran for tests in self._session.aggregation.ran.values() for ran in tests.items()]
        if not runs:
            return
        began_s = min(ran.start_s for _, ran in runs)
        for path in self._files(self._config.rootpath):
            try:
                written_s = path.stat().st_mtime
            except OSError:
                continue
            if written_s >= began_s - _COARSE_S:
                yield str(path), _test_at(written_s, runs)

    def _files(self, root: Path) -> Iterator[Path]:
        report, number = self._session.options.report.resolve(), 0
        for folder, names, files in os.walk(root):
            names[:] = sorted(
                name for name in names if name not in _LEFT_OUT and Path(folder, name).resolve() != report
            )
            for name in sorted(files):
                number += 1
                if number > _MAX_FILES:
                    return
                yield Path(folder, name)


_COARSE_S = 0.01
"""File systems take the time of a file from a clock that advances by some milliseconds at a time (Linux: 4 or 10)."""


def _test_at(time_s: float, runs: Sequence[tuple[str, TestTimes]]) -> str:
    """The test that ran at a time (s since 1970); empty if none did, or several."""
    running = [nodeid for nodeid, ran in runs if ran.start_s - _COARSE_S <= time_s <= ran.stop_s + _COARSE_S]
    return running[0] if len(running) == 1 else ""


def _violations(result: TestResult) -> frozenset[str]:
    return frozenset(name for name in result.requirements if result.violates(name))


MIN_TESTS = 3
"""Tests that every session runs again; 9 to 12 s of processor time with the table (`benchmarks.isolation`)."""

BUDGET = 0.03
"""Share of the time of all tests within which more run again; by the same benchmark, 3 to 4 % of a session."""


def choose_tests(results: Sequence[TestResult], place: Mapping[str, int], number: int | None) -> list[TestResult]:
    """The tests to run again, in order.

    Args:
        place: node id -> how many tests ran before it in its process; those that are not to run again have none.
        number: how many; None: `MIN_TESTS`, or more within `BUDGET` of the time.
    """
    ways: dict[tuple[object, ...], list[TestResult]] = defaultdict(list)
    for result in results:
        if result.nodeid in place and result.outcome != "not-run":
            ways[(not result.fails, result.outcome, result.end_reason, result.outcomes)].append(result)
    # Late tests of a process have the most predecessors that may have left something behind.
    lists = [sorted(group, key=lambda result: (-place[result.nodeid], result.id)) for group in ways.values()]
    lists.sort(key=lambda group: -sum(result.sim_s for result in group) / len(group))
    failing = [group for group in lists if group[0].fails]
    others = [group for group in lists if not group[0].fails]
    order = [*_in_turn(failing), *_in_turn(others)]
    if number is not None:
        return order[:number]
    # Real time ended tests that worked for too long, so their messages until then vary. One in error has its text only.
    order = [result for result in order if not took_long((*result.errors, result.failure))]
    budget_s = BUDGET * sum(result.wall_s or 0.0 for result in results)
    tests: list[TestResult] = []
    for result in order:
        budget_s -= result.wall_s or 0.0
        if len(tests) >= MIN_TESTS and budget_s < 0.0:
            break
        tests.append(result)
    return tests


def _in_turn(groups: Sequence[Sequence[TestResult]]) -> list[TestResult]:
    """The members of the groups in turn: one of each group, then the next of each."""
    return [result for row in zip_longest(*groups) for result in row if result is not None]
