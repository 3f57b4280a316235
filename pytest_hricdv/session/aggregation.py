"""`Aggregation`: collects the test results of all workers in the controlling process, and lists tests without a result.

`plugin` registers it as a pytest plugin. `SessionReporter` makes the report from its `results`, which a `ResultStore`
keeps compressed; its `journaling` writes each result to the journal.
"""

from __future__ import annotations

import os
import re
from collections.abc import KeysView, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from zlib import compress, decompress  # as they are now: the code under test may replace them for the whole process

import msgspec
import pytest

from pytest_hricdv._base.hash_seed import SEVERAL, hand_to_children, hash_seed_of_children, own_hash_seed
from pytest_hricdv.execution.hri_case import HriCase
from pytest_hricdv.report.formatting import plural
from pytest_hricdv.results.codec import decode, encode
from pytest_hricdv.results.journal import Journal
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.session.collection import ATTRIBUTE, WORKER_HASH_SEED, Collection, case_of
from pytest_hricdv.session.journaling import JournalKeeper
from pytest_hricdv.session.resuming import DONE
from pytest_hricdv.session.run_context import RunContext

_DIGEST = re.compile(r"-[0-9a-f]{8,16}(?:-corners)?(?:-k\d+)?(?=[-\]])")
BY_FILE = ("loadscope", "loadfile")
"""Values of xdist's option `--dist` that keep the tests of a module or class, or of a file, on one worker."""

FASTEST = 1
"""zlib's compression level for results: it leaves a quarter of the size in 0.5 ms; the best level saves little more."""


class ResultStore:
    """Node id -> result, as compressed JSON: results of thousands of tests would need gigabytes as objects.

    The last result that was put for a test counts, since a test that runs again counts once.
    """

    def __init__(self) -> None:
        self._packed: dict[str, bytes] = {}

    def resume(self, packed: Mapping[str, bytes]) -> None:
        """Begin with the results of an earlier session."""
        self._packed.update(packed)

    def put(self, nodeid: str, text: str) -> None:
        """Keep a result, as `pytest_hricdv.results.codec.encode` wrote it."""
        self._packed[nodeid] = compress(text.encode(), FASTEST)

    def nodeids(self) -> KeysView[str]:
        """The node ids of all results."""
        return self._packed.keys()

    def results(self) -> list[TestResult]:
        """All results, in the order in which their tests were first put."""
        return [decode(decompress(packed)) for packed in self._packed.values()]


class _Outcome(msgspec.Struct):
    """The part of a result that decides whether it has to be decoded on arrival."""

    outcome: str


class _Ran(msgspec.Struct, frozen=True):
    """The part of a result that is the same wherever a test runs."""

    outcome: str
    record_sha256: str | None = None


class EachWorker:
    """The results of a test on all workers, of which only the last one counts, with xdist's --dist=each."""

    def __init__(self) -> None:
        self._ran: dict[str, dict[str, _Ran]] = {}
        """Node id -> worker -> what came of it."""

    def add(self, nodeid: str, worker: str, result: str) -> None:
        """A result, as JSON."""
        self._ran.setdefault(nodeid, {})[worker] = msgspec.json.decode(result, type=_Ran)

    def note(self) -> str:
        """Why the report counts fewer tests than pytest; empty if no test ran twice."""
        workers = sorted({worker for ran in self._ran.values() for worker in ran})
        tests = plural(len(self._ran), "test")
        return f"--dist=each: {tests} ran on each of {', '.join(workers)}, and count once" if len(workers) > 1 else ""

    def differences(self) -> list[str]:
        """Tests with different results on two workers, a sentence each."""
        return [
            f"{nodeid} is not the same on each worker: "
            + "; ".join(
                f"{worker} {one.outcome}, record {(one.record_sha256 or 'none')[:8]}" for worker, one in ran.items()
            )
            for nodeid, ran in self._ran.items()
            if len(set(ran.values())) > 1
        ]


@dataclass
class TestTimes:
    """When a test began and ended, on the clock of its machine (s since 1970)."""

    start_s: float
    stop_s: float


class Aggregation:
    """Collects results by node id, writes replay files of failed tests, and finds out which results are missing."""

    def __init__(self, collection: Collection, context: RunContext) -> None:
        self.collection = collection
        self.context = context
        self.chosen: dict[str, HriCase] = {}
        """Node id -> test: the tests that were selected."""
        self.reasons: dict[str, str] = {}
        """Node id -> why the test has no result."""
        self.ran: dict[str, dict[str, TestTimes]] = {}
        """Worker (empty: this process) -> node id -> when it ran: all its tests, in their order, generated or not."""
        self.workers = 1
        self.is_distributed = False
        self.each_worker = EachWorker()
        self.worker_hash_seeds: set[str] = set()
        """The hash seeds that ended workers reported."""
        self.journaling = JournalKeeper(collection.options.report)
        self._results = ResultStore()

    def resume(self, earlier: Journal) -> None:
        """Begin with what an earlier session has done."""
        self._results.resume(earlier.results)
        self.reasons.update(earlier.reasons)

    @property
    def hash_seed(self) -> str:
        """The hash seed of the processes that run the tests, see `pytest_hricdv.results.origin.ReportOrigin`."""
        spawns = self.collection.options.isolate and not hasattr(os, "fork")
        expected = hash_seed_of_children() if self.is_distributed or spawns else own_hash_seed()
        seeds = self.worker_hash_seeds or {expected}
        return SEVERAL if len(seeds) > 1 else next(iter(seeds))

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        """Without xdist: stores which tests are selected."""
        for item in session.items:
            case = case_of(item)
            if case is not None:
                self.chosen[item.nodeid] = case

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_setupnodes(self, config: pytest.Config, specs: list[object]) -> None:
        """With xdist: stores the number of workers; replacements of crashed workers do not count.

        Workers take their hash seed from the environment of this process, in which no test runs.
        """
        config.add_cleanup(hand_to_children())
        self.workers = len(specs)
        self.is_distributed = True

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: object) -> None:
        """With xdist: stores a worker's hash seed, which on another machine is not that of this process."""
        seed = getattr(node, "workeroutput", {}).get(WORKER_HASH_SEED)
        self.worker_hash_seeds |= {seed} if seed else set()

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_node_collection_finished(self, node: object, ids: list[str]) -> None:
        """With xdist: stores which tests are selected, by the node ids that the workers report."""
        by_id = {case.abstract.id: case for case in self.collection.cases}
        for nodeid in ids:
            case = _case_named(nodeid, by_id)
            if case is not None:
                self.chosen[nodeid] = case

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Takes the result from a report, of whichever worker; the same test twice counts once.

        Before other plugins, as their hooks may raise: the result is safe by then. A report without a result says why
        there is none: skipped, a fixture that failed, a worker that crashed.
        """
        self._note_times(report)
        text = getattr(report, ATTRIBUTE, None)
        if isinstance(text, str):
            delattr(report, ATTRIBUTE)  # pytest keeps reports to the end
            text = self._with_replay(text)
            self.journaling.finish(report.nodeid, text)
            self._results.put(report.nodeid, text)
            if self.collection.config.getoption("dist", "no") == "each":
                self.each_worker.add(report.nodeid, getattr(report, "worker_id", ""), text)
        elif not report.passed and not hasattr(report, DONE):
            reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longreprtext
            self.reasons[report.nodeid] = reason
            if report.nodeid in self.chosen:
                self.journaling.hinder(report.nodeid, reason)

    def _note_times(self, report: pytest.TestReport) -> None:
        if hasattr(report, DONE):
            return
        node = getattr(report, "node", None)  # xdist's
        ran = self.ran.setdefault("" if node is None else str(node.gateway.id), {})
        times = ran.setdefault(report.nodeid, TestTimes(report.start, report.stop))
        times.stop_s = report.stop

    def _with_replay(self, text: str) -> str:
        """Writes the replay file of a failed test, unless it was replayed and so has one."""
        if msgspec.json.decode(text, type=_Outcome).outcome == "passed":
            return text
        result = decode(text)
        case = self.chosen.get(result.nodeid)
        if not result.leaves_evidence or result.replay is not None or case is None:
            return text
        provenance = replace(self.context.provenance, hash_seed=self.hash_seed)
        name = self.context.failures.keep(provenance.replay(case, result, self.seeds[case.suite]))
        return text if name is None else encode(msgspec.structs.replace(result, replay=name))

    def results(self) -> list[TestResult]:
        """All results."""
        return self._results.results()

    @cached_property
    def seeds(self) -> dict[str, int]:
        """Suite -> the seed that it was generated from."""
        return {generated.suite.name: generated.suite.seed for generated in self.collection.suites}

    def late_errors(self) -> list[str]:
        """Errors of tests that have a result nevertheless, as of a fixture that could not be torn down."""
        return [
            f"{nodeid}: an error after its result: {_cause(self.reasons[nodeid])}"
            for nodeid in sorted(self.reasons.keys() & self._results.nodeids())
        ]

    def notes(self) -> list[str]:
        """Notes on the effects of xdist's distribution modes on this session, a sentence each."""
        note = self.each_worker.note()
        one_file = len({nodeid.partition("::")[0] for nodeid in self.chosen}) == 1
        mode = str(self.collection.config.getoption("dist", "no"))
        if self.workers > 1 and len(self.chosen) > 1 and one_file and mode in BY_FILE:
            return [f"--dist={mode} gave all tests to one worker, as they are of one file; --dist=load spreads them"]
        return [note] if note else []

    def losses(self) -> list[str]:
        """Tests without a result or a reason: the session must not look as if all were well."""
        lost = len(self.chosen.keys() - self._results.nodeids() - self.reasons.keys())
        return (
            [f"{lost} of {len(self.chosen)} tests left no result: a worker, a plugin or an exit lost them"]
            if lost
            else []
        )


def _cause(text: str) -> str:
    """The line of a traceback, as pytest writes it, that says what was raised."""
    lines = text.strip().splitlines()
    raised = [line.removeprefix("E").strip() for line in lines if line.startswith("E ")]
    return "".join((raised or lines)[-1:])


def _case_named(nodeid: str, by_id: dict[str, HriCase]) -> HriCase | None:
    """The case whose id is in the brackets of a node id, perhaps among other parameters."""
    parameters = nodeid[nodeid.find("[") + 1 :]
    for match in _DIGEST.finditer(parameters):
        head = parameters[: match.end()]
        for start in [0, *(dash.end() for dash in re.finditer("-", head))]:
            if head[start:] in by_id:
                return by_id[head[start:]]
    return None
