"""`hricdv check`: the testbench's requirements on logs of the real robot.

    hricdv check hri-report/traces              # files of --hri-mcap need no map
    hricdv check run1.mcap --map-draft          # draft a map from topics and fields, to be completed
    hricdv check run1.mcap bag/ --map map.toml
    hricdv check run1.mcap --map map.toml --to-tests logged.txt   # then: pytest --hri-suite=logged.txt

    hricdv check logs/ --map map.toml --against hri-report -o log-report

Logs are MCAP files (JSON or ROS 2) and bags of ROS 2 (folders, *.db3). Several logs form a suite. If a log lacks data
or a topic, the requirements that read it are unknown, never passed. If its clock jumps, each part is judged separately.
The exit status is 0 if each requirement passed in a log and no violation is new, 1 otherwise, and 2 if a log or the map
cannot be read.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from pytest_hricdv._base.message import InputError, visible

if TYPE_CHECKING:
    from pytest_hricdv.extra.logs.feature import FleetComparison
    from pytest_hricdv.extra.logs.judging import JudgedRun
    from pytest_hricdv.extra.logs.log_map import LogMap
    from pytest_hricdv.monitor import Verdict
    from pytest_hricdv.recordings.bags import Value
    from pytest_hricdv.recordings.recording import RecordingReader
    from pytest_hricdv.results.model import Report
    from pytest_hricdv.session.run_context import RunContext

PURPOSE = "judge logs of the real robot by the testbench's requirements"
OK, VIOLATED, USAGE = 0, 1, 2
DRAFTED_FROM = 100_000
"""Maximum number of messages, from the beginning of a log, from which a map is drafted."""


def add_command(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command `check` to those of `hricdv`."""
    parser = commands.add_parser(
        "check", help=PURPOSE, description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.set_defaults(do=do)
    add = parser.add_argument
    add("logs", nargs="+", type=Path, metavar="LOG", help="MCAP file, bag, or folder of them")
    add("--map", type=Path, metavar="MAP.toml", help="maps topics and fields to messages and signals")
    add("--map-draft", action="store_true", help="print a draft of such a map; equal names are filled in")
    add("--to-tests", type=Path, metavar="FILE.txt", help="write the actions of people in the logs as abstract tests")
    add("--against", type=Path, metavar="REPORT", help="list what its tests cover and no log shows, and the reverse")
    add("-o", "--output", type=Path, metavar="DIR", help="write a report of the logs, with its page")
    add("--json", action="store_true", help="print the verdicts as JSON, a line for each log")


class _LogChecker:
    """Takes the place of the session once pytest has loaded the project's conftest, which has the testbench."""

    def __init__(self, options: argparse.Namespace) -> None:
        self._options = options

    @pytest.hookimpl(tryfirst=True)
    def pytest_cmdline_main(self, config: pytest.Config) -> int:
        from pytest_hricdv.session.collection import Collection
        from pytest_hricdv.session.options import read_options
        from pytest_hricdv.session.run_context import RunContext

        context = RunContext(Collection(config, read_options(config)))
        try:
            if self._options.map_draft:
                return _draft(self._options, context)
            if self._options.to_tests is not None:
                return _write_tests(self._options, context)
            return _LogCheck(self._options, context).run()
        except InputError as error:
            print(visible(f"error: check: {error}"), file=sys.stderr)
            return USAGE


def do(options: argparse.Namespace) -> int:
    """Judge the logs; returns the exit status."""
    # Assertions are not rewritten: pytest would warn about modules that this command has imported.
    status = pytest.main(["--assert=plain", "-p", "no:cacheprovider"], plugins=[_LogChecker(options)])
    return USAGE if status == pytest.ExitCode.USAGE_ERROR else int(status)


def _readers(options: argparse.Namespace) -> list[RecordingReader]:
    from pytest_hricdv.recordings.recording import recording_readers

    return recording_readers(options.logs, lambda kind: None)


def _draft(options: argparse.Namespace, context: RunContext) -> int:
    """Print a draft of the map, from the beginning of the first log."""
    from pytest_hricdv.extra.logs.log_map import draft_map

    fields: dict[str, dict[str, Value]] = {}
    for reader in _readers(options)[:1]:
        for number, (_, sample) in enumerate(reader.samples(lambda topic: {})):
            fields.setdefault(sample.topic, {}).update(sample.fields)
            if number > DRAFTED_FROM:
                break
        if not fields:
            raise InputError(" ".join(reader.problems) or f"{reader.name}: has no messages")
    print("\n".join(draft_map(fields, context.collection.testbench.vocabulary())))
    return OK


def _write_tests(options: argparse.Namespace, context: RunContext) -> int:
    from pytest_hricdv._base.atomic_file import write_text
    from pytest_hricdv.extra.logs import log_map, logged_actions, logged_run
    from pytest_hricdv.generate.abstract import identify
    from pytest_hricdv.generate.suite_files import dump_tests
    from pytest_hricdv.report.formatting import plural

    testbench = context.collection.testbench
    vocabulary = testbench.vocabulary()
    declared = log_map.read_map(options.map, vocabulary) if options.map else None
    if declared is None or not declared.actions:
        raise InputError("--to-tests: expected --map with [actions.NAME]: a topic and the command that it stands for")
    made = log_map.LogMap(time=declared.time, actions=declared.actions)
    logged, is_read = logged_actions.LoggedActions(testbench.concretization, made), True
    for recording in _readers(options):
        logged.add(logged_run.LogReader(recording, made, vocabulary))
        is_read &= _say_problems(recording)
    for text in logged.notes:
        print(visible(f"note: {text}"), file=sys.stderr)
    if not logged.drafts:
        raise InputError("--to-tests: no log has an action of the map; nothing was written")
    try:
        write_text(options.to_tests, dump_tests(identify("logged", 0, logged.drafts)))
    except OSError as error:
        raise InputError(f"--to-tests: {options.to_tests}: {error.strerror or error}") from None
    written = f"{plural(len(logged.drafts), 'test')} in {options.to_tests}"
    print(visible(f"{written}; now: pytest --hri-suite={options.to_tests}"))
    return OK if is_read else USAGE


class _LogCheck:
    """Judges logs one by one, then reports on all of them."""

    def __init__(self, options: argparse.Namespace, context: RunContext) -> None:
        from pytest_hricdv.execution.run_monitors import formulas
        from pytest_hricdv.extra.logs import log_map, log_report, logged_actions

        self._options, self._context = options, context
        testbench = context.collection.testbench
        self._testbench, self._vocabulary = testbench, testbench.vocabulary()
        self._requirements = formulas(context.requirements)
        declared = log_map.read_map(options.map, self._vocabulary, testbench.cross) if options.map else None
        self._map = declared
        self._actions = (
            logged_actions.LoggedActions(testbench.concretization, declared) if declared and declared.actions else None
        )
        self._report = log_report.LogReport(context, self._requirements)

    def run(self) -> int:
        """Judge all logs; returns the exit status."""
        from pytest_hricdv.extra.logs.log_report import summary_lines
        from pytest_hricdv.monitor.monitor_set import MonitorError
        from pytest_hricdv.report.totals import has_failed, list_gate_failures
        from pytest_hricdv.results.codec import load

        tests = None if self._options.against is None else load(self._options.against)  # before an hour of logs
        is_read = True
        for recording in _readers(self._options):
            try:
                self._judge(recording)
            except (MonitorError, InputError) as error:  # the other logs are judged
                text = f"error: check: {recording.name}: {error}"
                print(visible(text), file=sys.stderr)
                self._report.problems.append(text)
                is_read = False
            is_read &= _say_problems(recording)
        report = self._report.make()
        lines = [*summary_lines(report), *(f"  {fault}" for fault in self._report.faults)]
        comparison = None if tests is None else self._compare(report, tests)
        if comparison is not None:
            lines += [*comparison.only_tests, *comparison.only_logs]
        if not self._options.json:
            print(visible("\n".join(lines), keep="\n"))
        if self._options.output is not None:
            self._write(report, comparison)
        if not is_read:
            return USAGE
        return VIOLATED if has_failed(report) or list_gate_failures(report) else OK

    def _judge(self, recording: RecordingReader) -> None:
        from pytest_hricdv.extra.logs import judging, logged_run

        reader = logged_run.LogReader(recording, self._map_of(recording), self._vocabulary)
        draws = self._options.output is not None
        known_when = self._context.exemption_conditions
        for judged in judging.judge(reader, self._requirements, known_when, self._actions, draws=draws):
            self._report.add(judged)
            self._show(judged)

    def _map_of(self, recording: RecordingReader) -> LogMap:
        from pytest_hricdv.extra.logs.log_map import map_own_trace

        if self._map is not None:
            return self._map
        for _ in recording.samples(lambda topic: None):
            pass
        if recording.count and "/hricdv/end" not in recording.types:
            raise InputError("not a trace of --hri-mcap: expected --map; --map-draft drafts one")
        names = {requirement.id for requirement in self._context.requirements}
        return map_own_trace(recording.types, self._vocabulary, self._testbench.cross, names)

    def _compare(self, logs: Report, tests: Report) -> FleetComparison:
        from pytest_hricdv.extra.logs.feature import FleetComparison
        from pytest_hricdv.extra.logs.log_report import Occurrences

        names, commands = logs.requirements.keys() & tests.requirements.keys(), self._report.commands
        logged = Occurrences.of(logs, names, commands)
        tested = Occurrences.of(tests, names, None if commands else ())  # actions are compared only if the map has them
        only_tests, only_logs = tested.without(logged), logged.without(tested)
        if self._options.json:
            print(json.dumps({"only_tests": only_tests.data, "only_logs": only_logs.data}))
        return FleetComparison(
            against=str(self._options.against),
            only_tests=tuple(only_tests.lines("only in tests")),
            only_logs=tuple(only_logs.lines("only in logs")),
        )

    def _show(self, judged: JudgedRun) -> None:
        run = judged.run
        if self._options.json:
            content = {
                name: {"verdict": judged.word(name), "margin": verdict.margin, "unknown": judged.unknown.get(name, "")}
                for name, verdict in judged.verdicts.items()
            }
            print(json.dumps({"log": run.name, "end_s": run.end_s, "requirements": content}))
            return
        print(visible(f"{run.name}: {run.end_s:.3f} s"))
        for requirement in self._requirements:
            name = requirement.id
            verdict, unknown = judged.verdicts[name], judged.unknown.get(name, "")
            for line in _lines(judged.word(name), unknown, verdict, self._vocabulary.units, requirement.text):
                print(visible(line))

    def _write(self, report: Report, comparison: FleetComparison | None) -> None:
        from pytest_hricdv.extra.logs.feature import FLEET
        from pytest_hricdv.report.files import prepare, write

        prepare(self._options.output)
        files = write(FLEET.put(report, comparison), self._options.output)
        if not self._options.json:
            print(visible(f"  {files[-1]}"))


def _say_problems(recording: RecordingReader) -> bool:
    """Print the problems of a log; returns whether all of it was read."""
    for text in (*recording.problems, *recording.unreadable_lines(), *recording.jumps, *recording.notes):
        print(visible(f"note: {text}"), file=sys.stderr)
    if not recording.count and not recording.problems:
        print(visible(f"note: {recording.name}: has no messages: nothing was observed"), file=sys.stderr)
    return bool(recording.count) and not recording.is_cut


def _lines(word: str, unknown: str, verdict: Verdict, units: Mapping[str, str], text: str) -> Iterator[str]:
    from pytest_hricdv.report.explanation import near_miss
    from pytest_hricdv.report.violations import margin_text, unit_of, violation_line

    unit = unit_of(text, units)
    margin = "" if verdict.margin is None else f"  margin {margin_text(verdict.margin, unit)}"
    yield f"  {verdict.requirement:<6} {word:<8}{margin}"
    if unknown:
        yield f"         {unknown}"
    yield from (f"         {violation_line(violation, units, unit)}" for violation in verdict.violations)
    if verdict.near_miss:
        yield f"         {near_miss(verdict.near_miss)}"
