"""The first runs of a draft, in a folder and a process of their own: what holds, and what the code does outside."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pytest_hricdv.extra.draft import guard
from pytest_hricdv.extra.draft.drafted import ENDS, Draft
from pytest_hricdv.extra.draft.findings import Place, Problem
from pytest_hricdv.extra.draft.project import write
from pytest_hricdv.extra.draft.requirements_text import requirement_ids

LIMIT_S = 90.0
"""Processor time of the first runs of a suite (chosen: nobody waits for longer for a draft); then they are ended. It
is not the time of the clock, so that a busy machine drafts the same."""

LONGEST_S = 600.0
"""So long by the clock, where nothing says the processor time, or nothing is computed (chosen)."""

LOOKS_EACH_S = 0.5
"""How often the processor time is looked at."""

ENDING_S = 30.0
"""So long a session that was told to end may take for its report (chosen)."""

FIRST = 8
"""Tests of the very first runs (chosen: one has each start and most manners)."""

_ALLOW = re.compile(r'may_end=\("(\w+)",\)')
"""What a failure says that the testbench would have to allow."""

SUITES = ("rl", "closure")
"""The suites that are to be green."""


MEND = "what do the stand-ins of `ports.py` have to say there?"
"""What to do where the first runs raise."""

MEND_NODE = "which fields has what `said` in `conftest.py` sends it, and what do others answer?"
"""The same where the code is a node of ROS 2."""


def mend(draft: Draft, trial: Trial) -> str:
    """What to do where the first runs of a draft raise.

    What the code raises in some of them, and not in the others, most often is a fault of the code.
    """
    stand_ins = MEND if draft.ros is None else MEND_NODE
    if trial.raised_at is None or not 0 < trial.raised < trial.tests:
        return stand_ins
    share = f"{trial.raised} of {trial.tests} tests end so"
    return f"{share}: a fault of the code, for what it hears in them (`pytest` shows it)? if not, {stand_ins}"


@dataclass(frozen=True)
class Trial:
    """What came of the first runs.

    Args:
        tests: how many there were.
        passed: of them.
        failed: the requirements that failed in some, by their ids.
        never: those that none triggered.
        error: what the code raised or the testbench lacks, in a sentence; empty where all runs went through.
        effects: what the code would have done outside.
        raised_at: the line of the code that raised; None where it did not.
        is_ended: whether the runs took too long: the draft has as many tests as there were.
        unrepeatable: why a test came otherwise alone, in a fresh process; empty where those that ran again did not.
        leaks: whether that is what a test left to another one.
        raised: how many tests ended with an error.
        ends: of `may_end`, what the testbench does not allow, and ended a run.
    """

    tests: int
    passed: int
    failed: tuple[str, ...]
    never: tuple[str, ...]
    error: str
    effects: tuple[Problem, ...]
    raised_at: Place | None = None
    is_ended: bool = False
    unrepeatable: str = ""
    leaks: bool = False
    raised: int = 0
    ends: tuple[str, ...] = ()


def tried(draft: Draft, suites: Sequence[str] = SUITES) -> tuple[Draft, tuple[Trial, ...]]:
    """The draft after its first runs: requirements that do not hold are questions in it.

    A draft whose runs go round without time passing is tried once more with devices that take time, and one whose tests
    leave a state to each other with a process for each test. Runs may end as they did, and no other way.
    """
    trials: list[Trial] = []
    draft = replace(draft, may_end=())
    if "rl" in suites:  # few tests first: where much fails, all of them would take long
        draft, first = _ending(draft, "rl", FIRST)
        if first.error and "no simulated time" not in first.error and draft.has_others:
            without_others, known = _ending(replace(draft, has_others=False), "rl", FIRST)
            if not known.error:  # the code raises for a text that it does not know
                draft, first = without_others, known
        draft = replace(draft, takes_time="no simulated time" in first.error)
        draft = without(draft, first.failed)
    for suite in suites:
        draft, trial = _settled(draft, suite)
        trials.append(trial)
        draft = without(draft, trial.failed)
        if trial.is_ended and trial.tests:
            draft = replace(draft, sizes={**draft.sizes, suite: trial.tests})
        if trial.error:
            break
    ids = [name for subject, name in requirement_ids(draft).items() if subject not in draft.dropped]
    unseen = [name for name in ids if all(name in trial.never for trial in trials)]
    held = {*ids} - {*unseen}
    by_one = {name: suite for suite, trial in zip(suites, trials, strict=False) for name in trial.never if name in held}
    draft = replace(draft, untriggered=by_one)
    return _with_problems(without(draft, unseen), trials), tuple(trials)


def _settled(draft: Draft, suite: str) -> tuple[Draft, Trial]:
    """The runs of a suite, and the draft with what they need to end, and to repeat."""
    draft, trial = _ending(draft, suite)
    if trial.error and "no simulated time" in trial.error and not draft.takes_time:
        draft, trial = _ending(replace(draft, takes_time=True), suite)
    if trial.leaks and not draft.isolates:
        draft, trial = _ending(replace(draft, isolates=True), suite)
    return draft, trial


def _ending(draft: Draft, suite: str, tests: int | None = None) -> tuple[Draft, Trial]:
    """The runs of a suite, and the draft that allows how they end."""
    trial = run(draft, suite, tests)
    while ends := set(trial.ends) - set(draft.may_end):
        draft = replace(draft, may_end=tuple(end for end in ENDS if end in (*draft.may_end, *ends)))
        trial = run(draft, suite, tests)
    return draft, trial


def _with_problems(draft: Draft, trials: Sequence[Trial]) -> Draft:
    """The draft with what the runs have shown that somebody has to mend."""
    effects = tuple(dict.fromkeys(effect for trial in trials for effect in trial.effects))
    raised = tuple(
        Problem("raised", f"{_one_line(trial.error)}: the draft is not green; {mend(draft, trial)}", trial.raised_at)
        for trial in trials
        if trial.error
    )
    differing = tuple(
        Problem("unrepeatable", f"a run is another one when it is run again ({reason}): the draft is not green", None)
        for reason in dict.fromkeys(trial.unrepeatable for trial in trials if trial.unrepeatable)
    )
    findings = draft.findings
    return replace(draft, findings=replace(findings, problems=findings.problems + effects + raised + differing))


def _one_line(text: str) -> str:
    return " ".join(text.split())


def without(draft: Draft, names: Sequence[str]) -> Draft:
    """The draft, in which these requirements are questions."""
    subjects = {name: subject for subject, name in requirement_ids(draft).items()}
    dropped = tuple(subjects[name] for name in names if name in subjects)
    made = replace(draft, dropped=tuple(dict.fromkeys(draft.dropped + dropped)))
    return replace(made, has_dropped_all=made.has_dropped_all or {*subjects.values()} <= {*made.dropped})


def run(draft: Draft, suite: str, tests: int | None = None) -> Trial:
    """Run one suite of a draft, or so many of its tests."""
    with tempfile.TemporaryDirectory(prefix="hri-draft-") as name:
        folder = Path(name).resolve()
        write(replace(draft, folder=folder), folder)
        notes = folder / "effects.txt"
        environment = {
            **os.environ,
            guard.ROOT: draft.findings.root,
            guard.NOTES: str(notes),
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        command = [sys.executable, "-m", "pytest", "-q", "-p", guard.__name__, "-p", "no:cacheprovider",
                   f"--hri-suite={suite}"]  # fmt: skip
        command += [] if tests is None else [f"--hri-tests={tests}", "--hri-audit=off"]
        text, is_ended = _done(command, folder, environment)
        report = folder / "hri-report" / "report.json"
        if not report.exists():
            return Trial(0, 0, (), (), _last_error(text), _effects(notes))
        trial = _read(json.loads(report.read_text(encoding="utf-8")), _effects(notes))
        trial = replace(trial, raised_at=_raised_at(report, folder, Path(draft.findings.root)))
        return replace(trial, never=(), is_ended=True) if is_ended else trial


def _done(command: Sequence[str], folder: Path, environment: Mapping[str, str]) -> tuple[str, bool]:
    """What a command says; and whether it was ended, as a session that still reports what it has."""
    process = subprocess.Popen(
        command, cwd=folder, env=environment, text=True, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )  # fmt: skip
    begin_s = time.monotonic()
    while time.monotonic() - begin_s < LONGEST_S and _processor_s(process.pid) < LIMIT_S:
        try:
            return process.communicate(timeout=LOOKS_EACH_S)[0], False
        except subprocess.TimeoutExpired:
            continue
    process.terminate()
    try:
        return process.communicate(timeout=ENDING_S)[0], True
    except subprocess.TimeoutExpired:
        process.kill()
        return process.communicate()[0], True


def _processor_s(pid: int) -> float:
    """Processor time of a process and of those of its children that have ended; 0 where nothing says it."""
    try:
        parts = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    except OSError:
        return 0.0
    return sum(map(int, parts[11:15])) / os.sysconf("SC_CLK_TCK")


def _last_error(text: str) -> str:
    lines = [line for line in text.splitlines() if line.startswith(("ERROR", "E  ", "INTERNALERROR"))]
    return " ".join(lines[-3:])[:600] if lines else text.strip()[-300:]


def _effects(notes: Path) -> tuple[Problem, ...]:
    if not notes.exists():
        return ()
    problems = []
    for line in dict.fromkeys(notes.read_text(encoding="utf-8").splitlines()):
        place, _, told = line.partition("\t")
        file, _, number = place.rpartition(":")
        problems.append(Problem("side effect", f"the code {told}: refused in the first runs", Place(file, int(number))))
    return tuple(problems)


def _read(report: dict[str, Any], effects: tuple[Problem, ...]) -> Trial:
    tests = report["tests"]
    failed: dict[str, None] = {}
    triggers: dict[str, int] = dict.fromkeys(report["requirements"], 0)
    for test in tests:
        for name, result in test["requirements"].items():
            if result["failures"]:
                failed[name] = None
            triggers[name] = triggers.get(name, 0) + result["triggers"]
    never = [name for name, count in triggers.items() if not count]
    errors = [test["failure"] for test in tests if test["failure"] and not _is_of_requirements(test)]
    passed = sum(test["outcome"] == "passed" for test in tests)
    others = [test["unrepeatable"] for test in tests if test.get("unrepeatable")]
    return Trial(
        len(tests), passed, tuple(failed), tuple(never), _sentence(errors[0]) if errors else "", effects,
        unrepeatable=f"{others[0]['cause']}: {others[0]['detail']}" if others else "",
        leaks=any(other["left_by"] for other in others), raised=len(errors),
        ends=tuple(dict.fromkeys(end for test in tests for end in _ALLOW.findall(test["failure"] or ""))),
    )  # fmt: skip


def _raised_at(report: Path, folder: Path, root: Path) -> Place | None:
    """The last line of a failure that pytest names, where it is of the code."""
    for test in json.loads(report.read_text(encoding="utf-8"))["tests"]:
        if test["failure"] and not _is_of_requirements(test):
            for file, line in reversed(re.findall(r"^(\S+\.py):(\d+): ", test["failure"], re.MULTILINE)):
                path = (folder / file).resolve()
                if path.is_relative_to(root) and not path.is_relative_to(folder):
                    return Place(path.relative_to(root).as_posix(), int(line))
            return None
    return None


def _sentence(failure: str) -> str:
    """What was raised, without the way to it."""
    raised = [line[1:].strip() for line in failure.splitlines() if line.startswith("E ")]
    return (raised[0] if raised else failure.strip().splitlines()[0])[:600]


def _is_of_requirements(test: dict[str, Any]) -> bool:
    return any(result["failures"] for result in test["requirements"].values())
