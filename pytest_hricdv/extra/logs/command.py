"""`hricdv check`: the testbench's requirements on logs of the real robot.

    hricdv check hri-report/traces              # files of --hri-mcap: nothing else is needed
    hricdv check run1.mcap --map-draft          # a map of topics and fields, to be completed
    hricdv check run1.mcap bag/ --map map.toml
    hricdv check run1.mcap --map map.toml --to-tests logged.txt   # then: pytest --hri-suite=logged.txt

Logs are MCAP files (JSON, ROS 2), and bags of ROS 2 (folders, *.db3). Several are a suite. Where a log has no data, or
lacks a topic, requirements that read it are unknown, and never passed; where its clock jumps, it is judged in parts.
The exit status is 0 where each requirement has passed in a log, and failed in none; 1 otherwise; 2 where a log or the
map cannot be read.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from pytest_hricdv._base.message import InputError, visible

if TYPE_CHECKING:
    from pytest_hricdv.extra.logs.judging import LoggedRun, LogVerdict
    from pytest_hricdv.generate.concrete import Concretization
    from pytest_hricdv.monitor.requirement import Requirement
    from pytest_hricdv.monitor.vocabulary import Vocabulary
    from pytest_hricdv.recordings.recording import Recording

PURPOSE = "judge logs of the real robot by the testbench's requirements"
OK, VIOLATED, USAGE = 0, 1, 2


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
    parser.add_argument("--json", action="store_true", help="print the verdicts as JSON, a line for each log")


class _Checking:
    """Does all in pytest's place once it has loaded the project's conftest, which has the testbench."""

    def __init__(self, options: argparse.Namespace) -> None:
        self._options = options

    @pytest.hookimpl(tryfirst=True)
    def pytest_cmdline_main(self, config: pytest.Config) -> int:
        from pytest_hricdv.execution.run_monitors import formulas
        from pytest_hricdv.session.collection import Collection
        from pytest_hricdv.session.options import read_options
        from pytest_hricdv.session.run_context import RunContext

        context = RunContext(Collection(config, read_options(config)))
        vocabulary, requirements = context.collection.testbench.vocabulary(), formulas(context.requirements)
        try:
            if self._options.to_tests is not None:
                return _write_tests(self._options, vocabulary, context.collection.testbench.concretization)
            return _check(self._options, vocabulary, requirements)
        except InputError as error:
            print(visible(f"error: check: {error}"), file=sys.stderr)
            return USAGE


def do(options: argparse.Namespace) -> int:
    """Judge the logs; returns the exit status."""
    # Nothing is rewritten: it would warn of modules that this command has imported.
    status = pytest.main(["--assert=plain", "-p", "no:cacheprovider"], plugins=[_Checking(options)])
    return USAGE if status == pytest.ExitCode.USAGE_ERROR else int(status)


def _check(options: argparse.Namespace, vocabulary: Vocabulary, requirements: Sequence[Requirement]) -> int:
    from pytest_hricdv.extra.logs import judging, log_map
    from pytest_hricdv.monitor.monitor_set import MonitorError
    from pytest_hricdv.recordings.recording import read_recordings

    given = log_map.read_map(options.map, vocabulary) if options.map else None
    topics = {source.topic for source in given.sources.values()} if given else set()
    counts: dict[str, Counter[str]] = {requirement.id: Counter() for requirement in requirements}
    is_read = True
    is_wanted = (lambda topic: True) if options.map_draft or given is None else topics.__contains__
    for recording in read_recordings(options.logs, is_wanted, lambda kind: None):
        if options.map_draft:
            print("\n".join(log_map.draft_map([recording], vocabulary)))
            return OK
        is_read &= _say_problems(recording)
        if not recording.parts:
            continue
        try:
            if given is None and "/hricdv/end" not in recording.topics:
                raise InputError("no trace of --hri-mcap: expected --map; --map-draft begins one")
            made = given or log_map.of_own_trace(recording.topics, vocabulary)
            for run in judging.runs_of(recording, made, vocabulary):
                verdicts = judging.judge(requirements, run)
                for verdict in verdicts:
                    counts[verdict.requirement][verdict.verdict] += 1
                _show(run, verdicts, vocabulary, requirements, as_json=options.json)
        except (MonitorError, InputError) as error:  # the other logs are judged
            print(visible(f"error: check: {recording.name}: {error}"), file=sys.stderr)
            is_read = False
    if not options.json:
        print("\n".join(_summary(counts)))
    if not is_read:
        return USAGE
    return OK if all(count["Passed"] and not count["Failed"] for count in counts.values()) else VIOLATED


def _write_tests(options: argparse.Namespace, vocabulary: Vocabulary, concretization: Concretization) -> int:
    from pytest_hricdv._base.atomic_file import write_text
    from pytest_hricdv.extra.logs import log_map, logged_actions
    from pytest_hricdv.generate.abstract import identify
    from pytest_hricdv.generate.suite_files import dump_tests
    from pytest_hricdv.recordings.recording import read_recordings
    from pytest_hricdv.report.formatting import plural

    given = log_map.read_map(options.map, vocabulary) if options.map else None
    if given is None or not given.actions:
        raise InputError("--to-tests: expected --map with [actions.NAME]: a topic and the command that it stands for")
    logged, is_read = logged_actions.LoggedActions(concretization, given), True
    topics = {source.topic for source in given.actions.values()}
    for recording in read_recordings(options.logs, topics.__contains__, lambda kind: None):
        is_read &= _say_problems(recording)
        logged.add(recording)
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


def _say_problems(recording: Recording) -> bool:
    """Print what is wrong with a log; returns whether all of it was read."""
    for text in (*recording.problems, *recording.notes):
        print(visible(f"note: {text}"), file=sys.stderr)
    return bool(recording.parts) and not recording.is_cut


def _show(
    run: LoggedRun,
    verdicts: Sequence[LogVerdict],
    vocabulary: Vocabulary,
    requirements: Sequence[Requirement],
    *,
    as_json: bool,
) -> None:
    if as_json:
        content = {
            each.requirement: {"verdict": each.verdict, "margin": each.margin, "unknown": each.unknown}
            for each in verdicts
        }
        print(json.dumps({"log": run.name, "end_s": run.log.end_s, "requirements": content}))
        return
    print(visible(f"{run.name}: {run.log.end_s:.3f} s"))
    texts = {requirement.id: requirement.text for requirement in requirements}
    for each in verdicts:
        for line in _lines(each, vocabulary.units, texts[each.requirement]):
            print(visible(line))


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


def _summary(counts: Mapping[str, Counter[str]]) -> Iterator[str]:
    words = ("Passed", "Failed", "NC", "unknown")
    yield f"\n  {'':<8}{''.join(f'{word:>9}' for word in words)}"
    for name, count in counts.items():
        yield f"  {name:<8}{''.join(f'{count[word]:>9}' for word in words)}"
