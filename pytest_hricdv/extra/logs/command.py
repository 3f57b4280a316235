"""`hricdv check`: the testbench's requirements on logs of the real robot.

    hricdv check hri-report/traces              # files of --hri-mcap: nothing else is needed
    hricdv check run1.mcap --map-draft          # a map of topics and fields, to be completed
    hricdv check run1.mcap bag/ --map map.toml
    hricdv check run1.mcap --map map.toml --to-tests logged.txt   # then: pytest --hri-suite=logged.txt

    hricdv check logs/ --map map.toml --against hri-report -o log-report

Logs are MCAP files (JSON, ROS 2), and bags of ROS 2 (folders, *.db3). Several are a suite. Where a log has no data, or
lacks a topic, requirements that read it are unknown, and never passed; where its clock jumps, it is judged in parts.
The exit status is 0 where each requirement has passed in a log, and failed in none unless that is known; 1 otherwise;
2 where a log or the map cannot be read.
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
    from pytest_hricdv.extra.logs.fleet import Fleet
    from pytest_hricdv.extra.logs.judging import JudgedRun, LogVerdict
    from pytest_hricdv.extra.logs.log_map import LogMap
    from pytest_hricdv.extra.logs.log_report import LogReport
    from pytest_hricdv.extra.logs.logged_actions import LoggedActions
    from pytest_hricdv.recordings.bags import Value
    from pytest_hricdv.recordings.recording import RecordingReader
    from pytest_hricdv.session.run_context import RunContext

PURPOSE = "judge logs of the real robot by the testbench's requirements"
OK, VIOLATED, USAGE = 0, 1, 2
DRAFTED_FROM = 100_000
"""Messages of a log that the draft of a map is made from: the first ones."""


def add_command(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command `check` to those of `hricdv`."""
    parser = commands.add_parser("check", help=PURPOSE, description=__doc__)
    parser.set_defaults(do=do)
    parser.add_argument("logs", nargs="+", type=Path, metavar="LOG", help="MCAP file, bag, or folder of them")
    parser.add_argument(
        "--map", type=Path, metavar="MAP.toml", help="a map from topics and fields to messages and signals"
    )
    parser.add_argument("--map-draft", action="store_true", help="print a draft of such a map, as far as names match")
    parser.add_argument(
        "--to-tests", type=Path, metavar="FILE.txt", help="write what people do in the logs as abstract tests"
    )
    parser.add_argument(
        "--against", type=Path, metavar="REPORT", help="say what its tests cover that no log shows, and the reverse"
    )
    parser.add_argument("-o", "--output", type=Path, metavar="DIR", help="write a report of the logs, with its page")
    parser.add_argument("--json", action="store_true", help="print the verdicts as JSON, a line for each log")


class _Checking:
    """Does all in pytest's place once it has loaded the project's conftest, which has the testbench."""

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
    # Nothing is rewritten: it would warn of modules that this command has imported.
    status = pytest.main(["--assert=plain", "-p", "no:cacheprovider"], plugins=[_Checking(options)])
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
    given = log_map.read_map(options.map, vocabulary) if options.map else None
    if given is None or not given.actions:
        raise InputError("--to-tests: expected --map with [actions.NAME]: a topic and the command that it stands for")
    made = log_map.LogMap(time=given.time, actions=given.actions)
    logged, is_read = logged_actions.LoggedActions(testbench.concretization, made), True
    for recording in _readers(options):
        logged.add(logged_run.LogReader(recording, made, vocabulary))
        is_read &= _say_problems(recording)
    for text in logged.notes:
        print(visible(f"note: {text}"), file=sys.stderr)
    if not logged.drafts:
        raise InputError("--to-tests: in no log does anybody do anything that the map knows; nothing was written")
    try:
        write_text(options.to_tests, dump_tests(identify("logged", 0, logged.drafts)))
    except OSError as error:
        raise InputError(f"--to-tests: {options.to_tests}: {error.strerror or error}") from None
    written = f"{plural(len(logged.drafts), 'test')} in {options.to_tests}"
    print(visible(f"{written}; now: pytest --hri-suite={options.to_tests}"))
    return OK if is_read else USAGE


class _LogCheck:
    """Judges logs one after the other, and says what they show together."""

    def __init__(self, options: argparse.Namespace, context: RunContext) -> None:
        from pytest_hricdv.execution.run_monitors import formulas
        from pytest_hricdv.extra.logs import fleet, log_map, log_report, logged_actions

        self._options, self._context = options, context
        testbench = context.collection.testbench
        self._testbench, self._vocabulary = testbench, testbench.vocabulary()
        self._requirements = formulas(context.requirements)
        self._map = log_map.read_map(options.map, self._vocabulary, testbench.cross) if options.map else None
        has_actions = self._map is not None and self._map.actions
        self._actions: LoggedActions | None = (
            logged_actions.LoggedActions(testbench.concretization, self._map) if self._map and has_actions else None
        )
        self._fleet: Fleet = fleet.Fleet(
            [requirement.id for requirement in self._requirements],
            testbench.cross,
            context.options.gates.allowed_untriggered.keys(),
        )
        self._report: LogReport | None = log_report.LogReport(context, self._requirements) if options.output else None

    def run(self) -> int:
        """Judge all; returns the exit status."""
        from pytest_hricdv.monitor.monitor_set import MonitorError
        from pytest_hricdv.results.codec import load

        tests = None if self._options.against is None else load(self._options.against)  # before an hour of logs
        is_read = True
        for recording in _readers(self._options):
            try:
                self._judge(recording)
            except (MonitorError, InputError) as error:  # the other logs are judged
                self._note(f"error: check: {recording.name}: {error}")
                is_read = False
            is_read &= _say_problems(recording)
        lines, comparison = [*self._fleet.lines()], None
        if tests is not None:
            from pytest_hricdv.extra.logs.feature import FleetComparison
            from pytest_hricdv.extra.logs.fleet import compare

            only_tests, only_logs = compare(self._fleet, tests)
            comparison = FleetComparison(
                against=str(self._options.against),
                only_tests=tuple(only_tests.lines("tests, and no log")),
                only_logs=tuple(only_logs.lines("logs, and no test")),
            )
            lines += [*comparison.only_tests, *comparison.only_logs]
            if self._options.json:
                print(json.dumps({"only_tests": only_tests.data, "only_logs": only_logs.data}))
        if not self._options.json:
            print(visible("\n".join(lines), keep="\n"))
        self._write(comparison)
        if not is_read:
            return USAGE
        return OK if self._fleet.is_good else VIOLATED

    def _judge(self, recording: RecordingReader) -> None:
        from pytest_hricdv.extra.logs import judging, logged_run

        reader = logged_run.LogReader(recording, self._map_of(recording), self._vocabulary)
        for judged in judging.judge(
            reader, self._requirements, self._context.known_when, self._actions, draws=self._report is not None
        ):
            cross = self._fleet.add(judged, self._context.known_violations)
            if self._report is not None:
                self._report.add(judged, cross)
            self._show(judged)

    def _map_of(self, recording: RecordingReader) -> LogMap:
        from pytest_hricdv.extra.logs.log_map import of_own_trace

        if self._map is not None:
            return self._map
        for _ in recording.samples(lambda topic: None):
            pass
        if recording.count and "/hricdv/end" not in recording.types:
            raise InputError("no trace of --hri-mcap: expected --map; --map-draft begins one")
        return of_own_trace(recording.types, self._vocabulary, self._testbench.cross)

    def _note(self, text: str) -> None:
        print(visible(text), file=sys.stderr)
        if self._report is not None:
            self._report.problems.append(text)

    def _show(self, judged: JudgedRun) -> None:
        run = judged.run
        if self._options.json:
            content = {
                each.requirement: {"verdict": each.verdict, "margin": each.margin, "unknown": each.unknown}
                for each in judged.verdicts
            }
            print(json.dumps({"log": run.name, "end_s": run.end_s, "requirements": content}))
            return
        print(visible(f"{run.name}: {run.end_s:.3f} s"))
        texts = {requirement.id: requirement.text for requirement in self._requirements}
        for each in judged.verdicts:
            for line in _lines(each, self._vocabulary.units, texts[each.requirement]):
                print(visible(line))

    def _write(self, comparison: FleetComparison | None) -> None:
        if self._report is None:
            return
        from pytest_hricdv.extra.logs.feature import FLEET
        from pytest_hricdv.report.files import prepare, write

        counts = self._fleet.verdicts.items()
        gates = [f"{name} is unknown in {count['unknown']} logs" for name, count in counts if count["unknown"]]
        gates += [f"{name} was checked in no log" for name in self._fleet.gaps]
        prepare(self._options.output)
        files = write(FLEET.put(self._report.make([*gates, *self._fleet.faults]), comparison), self._options.output)
        if not self._options.json:
            print(visible(f"  {files[-1]}"))


def _say_problems(recording: RecordingReader) -> bool:
    """Print what is wrong with a log; returns whether all of it was read."""
    for text in (*recording.problems, *recording.unreadable_lines(), *recording.jumps, *recording.notes):
        print(visible(f"note: {text}"), file=sys.stderr)
    if not recording.count and not recording.problems:
        print(visible(f"note: {recording.name}: has no messages: nothing was observed"), file=sys.stderr)
    return bool(recording.count) and not recording.is_cut


def _lines(each: LogVerdict, units: Mapping[str, str], text: str) -> Iterator[str]:
    from pytest_hricdv.report.explanation import near_miss
    from pytest_hricdv.report.violations import margin_text, unit_of, violation_line

    unit = unit_of(text, units)
    margin = "" if each.margin is None else f"  margin {margin_text(each.margin, unit)}"
    yield f"  {each.requirement:<6} {each.verdict:<8}{margin}"
    if each.unknown:
        yield f"         {each.unknown}"
    for part in each.stretches:
        yield from (f"         {violation_line(violation, units, unit)}" for violation in part.violations)
        if part.near_miss and each.verdict == "NC":
            yield f"         {near_miss(part.near_miss)}"
