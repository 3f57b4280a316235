"""Replaying (`--hri-replay`): turns replay files into the session's tests, and compares each run with the recorded one.

`Collection` reads the files with `read_replays`; `TestRunner` compares by `Provenance`; `Aggregation` writes the replay
files of failing tests by `Failures`. Features run other tests, such as shrunk ones, by `TestRerunner`.
"""

from __future__ import annotations

import contextlib
import io
import os
import platform
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path

import msgspec
from msgspec import to_builtins

from pytest_hricdv._base import own_json as json
from pytest_hricdv._base.hash_seed import hash_seed_difference, own_hash_seed
from pytest_hricdv.coverage.code_map import CodeMap
from pytest_hricdv.execution.case import CaseResult, RunSettings, execute
from pytest_hricdv.execution.execution_feature import Watcher
from pytest_hricdv.execution.faults import CodeUnderTest
from pytest_hricdv.execution.hri_case import HriCase
from pytest_hricdv.generate.abstract import slug
from pytest_hricdv.generate.concrete import ConcreteTest, abstract_from
from pytest_hricdv.generate.rng import digest
from pytest_hricdv.generate.sampler import Sampler
from pytest_hricdv.generate.schedule import schedule_to_data
from pytest_hricdv.generate.suite import Generation, Suite
from pytest_hricdv.monitor import RequirementResult
from pytest_hricdv.results.model import ReplayComparison, TestResult
from pytest_hricdv.results.replay import Replay, ReplayError, ReplayOrigin, differences, read, write
from pytest_hricdv.results.report_builder import GeneratedSuite, build_result
from pytest_hricdv.session.option import usage_error
from pytest_hricdv.session.suites import check_commands
from pytest_hricdv.testbench import Testbench

FOLDER = "failures"
"""The folder of replay files in the folder of the report."""

_DIGITS = 8
"""Number of hexadecimal digits, from the hash of a test's content, at the end of its id."""


def _shorten(result: RequirementResult) -> RequirementResult:
    """The first 1000 violations: there may be one for each event, and with a million the file would be too large."""
    return msgspec.structs.replace(result, violations=result.violations[:1000])


@dataclass(frozen=True)
class ReplayInput:
    """A replay file that the session was given: its name for people, and what is in it."""

    name: str
    replay: Replay


def read_replays(paths: Iterable[Path], testbench: Testbench, start: Path) -> tuple[ReplayInput, ...]:
    """Read replay files, or folders of them.

    Args:
        testbench: the tests are to be run with.
        start: the folder that names are shown relative to.

    Raises:
        pytest.UsageError: a file is missing, cut off, of another version, or speaks of what the testbench has not.
    """
    by_test: dict[str, ReplayInput] = {}
    try:
        for path in _files(paths):
            name = os.path.relpath(path, start)
            replay = Replay.from_json(read(path), name)
            _check_parameters(replay, testbench, name)
            if replay.test.id in by_test:
                raise ReplayError(f"{by_test[replay.test.id].name} and {name} both have the test {replay.test.id}")
            by_test[replay.test.id] = ReplayInput(name, replay)
    except ReplayError as error:
        raise usage_error(f"--hri-replay: {error}") from None
    return tuple(by_test.values())


def _files(paths: Iterable[Path]) -> Iterable[Path]:
    for path in paths:
        if not path.is_dir():
            yield path
            continue
        inside = sorted(path.glob("*.json"))
        if not inside:
            raise ReplayError(f"{path}: no replay file (*.json) in this folder")
        for file in inside:
            if file.is_symlink():
                raise ReplayError(f"{file}: a symbolic link, which is not followed in a folder: name its target")
        yield from inside


def _check_parameters(replay: Replay, testbench: Testbench, name: str) -> None:
    ranges = testbench.commands
    for number, action in enumerate(replay.concrete.actions, 1):
        if action.command in ranges.commands:
            declared = ranges.commands[action.command]
            _check_names(f"{name}: action {number}, {action.command!r}", action.parameters, declared)
    _check_names(f"{name}: the run", replay.concrete.run, ranges.run)


def _check_names(where: str, parameters: Mapping[str, float], declared: Mapping[str, Sampler]) -> None:
    if parameters.keys() != declared.keys():
        has, expected = (", ".join(sorted(names)) or "none" for names in (parameters, declared))
        raise ReplayError(f"{where} has the parameters {has}; the testbench declares {expected}")


def suites(replays: Iterable[ReplayInput], testbench: Testbench) -> list[GeneratedSuite]:
    """The tests of replay files, as suites with the names and seeds that they come from."""
    by_name: dict[str, list[Replay]] = {}
    for file in replays:
        by_name.setdefault(file.replay.test.suite, []).append(file.replay)
    made = []
    for name, group in by_name.items():
        tests = [replay.test for replay in group]
        suite = Suite.of_tests(name, group[0].suite_seed, tests, Generation(notes=("replayed",)))
        check_commands(suite, testbench)
        made.append(GeneratedSuite(suite, 0.0, cached=True))
    return made


def to_text(replays: Iterable[ReplayInput]) -> str:
    """The files as text for xdist's `workerinput`."""
    return json.dumps([[file.name, file.replay.to_json()] for file in replays])


def from_text(text: str) -> tuple[ReplayInput, ...]:
    """The files that `to_text` wrote."""
    return tuple(ReplayInput(name, Replay.from_json(replay, name)) for name, replay in json.loads(text))


@dataclass(frozen=True)
class Provenance:
    """The dependencies of a run besides its test: files of the code under test, versions, and Python's hash seed."""

    code: Mapping[str, str]
    environment: Mapping[str, str]
    hash_seed: str

    @classmethod
    def now(cls, code: CodeMap, testbench: Testbench) -> Provenance:
        """The environment of this process."""
        environment = {
            "pytest-hricdv": version("pytest-hricdv"),
            "python": platform.python_version(),
            "machine": f"{platform.system()} {platform.machine()}",
            "testbench": testbench.name,
        }
        return cls(code.contents, environment, own_hash_seed())

    def replay(self, case: HriCase, result: TestResult, suite_seed: int, origin: ReplayOrigin | None = None) -> Replay:
        """The replay file of a test that was run here."""
        return Replay(
            test=case.abstract,
            concrete=case.concrete,
            nodeid=result.nodeid,
            suite_seed=suite_seed,
            record_sha256=result.record_sha256,
            requirements={name: to_builtins(_shorten(checked)) for name, checked in result.requirements.items()},
            code=self.code,
            environment=self._with_simulation(result),
            origin=origin,
            hash_seed=self.hash_seed,
        )

    def compare(self, file: ReplayInput, result: TestResult) -> ReplayComparison:
        """How the run of a replayed test compares with the recorded one."""
        expected = file.replay.record_sha256
        return ReplayComparison(
            file=file.name,
            expected_sha256=expected,
            same=expected == result.record_sha256,
            changed=(*_note_edit(file.replay), *differences(file.replay, self.code, self._with_simulation(result))),
            hash_seed=hash_seed_difference(file.replay.hash_seed, self.hash_seed),
        )

    def note(self, file: ReplayInput) -> str:
        """The note on a file before its test runs: what has changed; empty if nothing has."""
        before = {name: text for name, text in file.replay.environment.items() if name in self.environment}
        changed = differences(replace(file.replay, environment=before), self.code, self.environment)
        return f"{file.name}: {', '.join(changed)}: its run need not be the same again" if changed else ""

    def _with_simulation(self, result: TestResult) -> dict[str, str]:
        simulation = {"fidelity": result.fidelity, "engine": result.engine}
        return {**self.environment, **{name: value for name, value in simulation.items() if value}}


def _note_edit(replay: Replay) -> Iterator[str]:
    """Of a test that was made from another one, which its id shows: whether somebody has changed it."""
    made = replay.concrete
    if replay.origin is not None and name_test(made, "").id[-_DIGITS:] != made.id[-_DIGITS:]:
        yield "the test was edited"


def replay_mismatch(replayed: ReplayComparison | None) -> str:
    """Describes a replay that unexpectedly differs from its recorded run; empty if it is the same, or no replay."""
    if replayed is None or replayed.same or replayed.changed:
        return ""
    return (
        f"this run differs from the one in {replayed.file}: the hash of its record is not "
        f"{replayed.expected_sha256}\n"
        "The code under test, the plugin and Python are as they were, so something else that the run depends on has "
        "changed:\nthe testbench, its world, a library, or what another test left in its process. If it differs "
        "again,\nthe audit at the end of this session names the cause; for what other tests leave, run the "
        f"whole suite with --hri-audit=20.{_other_hash_seed(replayed.hash_seed)}"
    )


def _other_hash_seed(difference: str) -> str:
    if not difference:
        return ""
    remedy = f" (PYTHONHASHSEED={difference.split(',')[0]} repeats it)" if difference[0].isdigit() else ""
    return (
        f"\nOr it is Python's hash seed, {difference}{remedy}, which determines in which order code iterates over sets."
    )


class Failures:
    """Writes a file for each test that can be replayed. For the controlling process: no two write the same file.

    Args:
        start: the folder in which pytest was started: names are shown relative to it.
    """

    def __init__(self, folder: Path, start: Path) -> None:
        self._folder = folder / FOLDER
        self._start = start
        self.problem = ""

    def name(self, test_id: str) -> str:
        """How a test's file is given to `--hri-replay`."""
        return os.path.relpath(self._folder / f"{test_id}.json", self._start)

    def keep(self, replay: Replay) -> str | None:
        """Write a file; returns its name, or None if it cannot be written: `problem` then says why."""
        try:
            write(replay, self._folder)
        except ReplayError as error:
            self.problem = str(error)
            return None
        return self.name(replay.test.id)


@dataclass(frozen=True)
class TestRerunner:
    """Runs tests that no suite has, and keeps the ones worth it as replay files.

    Args:
        settings: the settings of the session's runs.
        provenance: what runs depend on in this process.
        failures: keeps files.
        seeds: suite -> the seed that it was generated from.
        let_through: while a test runs, a signal may raise.
    """

    settings: RunSettings
    provenance: Provenance
    failures: Failures
    seeds: Mapping[str, int]
    let_through: Callable[[], AbstractContextManager[None]] = contextlib.nullcontext

    def run(
        self,
        test: ConcreteTest,
        begun: Callable[[CodeUnderTest], None] = lambda code: None,
        watching: Iterable[Watcher] = (),
    ) -> CaseResult | None:
        """Run a test; None if the run did not end. Its output is discarded.

        Args:
            test: the test to run.
            begun: see `execute`.
            watching: see `execute`.
        """
        try:
            with self.let_through(), contextlib.redirect_stdout(io.StringIO()):
                return execute(self.settings, test, begun=begun, watching=watching)
        except Exception:
            return None

    def is_violated(self, requirement: str, result: RequirementResult) -> bool:
        """Whether it is, and, where its violations are known under a condition only, outside of that."""
        return result.verdict == "Failed" and (requirement not in self.settings.known_when or result.outside)

    def keep(self, case: HriCase, result: CaseResult, nodeid: str, origin: ReplayOrigin) -> tuple[HriCase, str | None]:
        """Keep a test made from `case` with its result; returns it, and the name of its replay file if it has one."""
        target, name = f"{origin.requirement} {origin.how}", case.abstract.name
        test = abstract_from(result.test, target, name=name, keeps_id=True)
        made = HriCase(case.suite, test, case.ranges, fixed=result.test)
        path, bracket, _ = nodeid.partition(f"[{case.abstract.id}")
        new_nodeid = f"{path}[{test.id}]" if bracket else nodeid
        built = build_result(made, new_nodeid, result, requirements=self.settings.requirements)
        return made, self.failures.keep(self.provenance.replay(made, built, self.seeds[case.suite], origin))


def name_test(test: ConcreteTest, made_by: str) -> ConcreteTest:
    """The test with a new id, made from how it was made and from its content, so that equal tests have equal ids."""
    actions = [[action.command, sorted(action.parameters.items())] for action in test.actions]
    after = [sorted(test.after.items())] if test.after else []
    schedule = [msgspec.to_builtins(schedule_to_data(test.schedule))] if test.schedule else []
    content = digest("made", test.suite, test.seed, actions, sorted(test.run.items()), *after, *schedule)
    return replace(test, id=f"{slug(test.suite)}-{slug(made_by)}-{content[:_DIGITS]}")
