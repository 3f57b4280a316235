"""The first runs of a draft, in their own process and folder.

Suggested requirements that hold there are kept, and endings that occur there are allowed; the rest become questions.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pytest_hricdv.extra.draft.code_model import CodeLine, Problem
from pytest_hricdv.extra.draft.project.draft import ENDS, Draft
from pytest_hricdv.extra.draft.project.files import write
from pytest_hricdv.extra.draft.project.requirements import requirement_ids

LIMIT_S = 90.0
"""Limit of processor time for the first runs of a suite, instead of wall time: a busy machine makes the same draft."""

LONGEST_S = 600.0
"""Limit of wall time, for when processor time is unknown or nothing is computed."""

POLL_S = 0.5
"""Period at which the processor time is read."""

ENDING_S = 30.0
"""Time that a terminated session gets to write its report."""

FIRST_TESTS = 8
"""Tests of the first suite, with each start belief and most other beliefs."""

SUITES = ("rl", "closure")
"""The suites that have to pass."""

_WAIVED = re.compile(r"(\S+\.py:\d+): ran, though it is waived")
"""The message for a wrong waiver in the code."""

_ALLOW = re.compile(r'allowed_endings=\("(\w+)",\)')
"""The ending that the testbench would have to allow, in the message of a failure."""


@dataclass(frozen=True)
class FirstRuns:
    """The result of the first runs.

    Args:
        tests: number of tests.
        passed: number of tests that passed.
        failed: ids of requirements that failed in some test.
        never: ids of requirements that no test triggered.
        error: what the code raised or the testbench lacks, in a sentence; empty if all runs completed.
        raised_at: the line of the code that raised; None if none did.
        is_ended: whether the runs took too long; the draft then has as many tests as had run.
        unrepeatable: why a test behaved differently when rerun alone in a fresh process; empty if none did.
        leaks: whether the reason is state that a test left behind.
        raised: number of tests that ended with an error.
        ends: endings that occurred and that the testbench does not allow (`allowed_endings`).
        no_waivers: lines executed although the code waives them as unreachable, as `file:line`.
    """

    tests: int
    passed: int
    failed: tuple[str, ...]
    never: tuple[str, ...]
    error: str
    raised_at: CodeLine | None = None
    is_ended: bool = False
    unrepeatable: str = ""
    leaks: bool = False
    raised: int = 0
    ends: tuple[str, ...] = ()
    no_waivers: str = ""


@dataclass(frozen=True)
class _Session:
    """What a session of a draft said, its report if there is one, and where the code raised."""

    text: str
    is_ended: bool
    report: dict[str, Any] | None
    raised_at: CodeLine | None = None


def _session(draft: Draft, options: Sequence[str]) -> _Session:
    """Run pytest in a folder with a draft."""
    with tempfile.TemporaryDirectory(prefix="hri-draft-") as name:
        folder = Path(name).resolve()
        write(replace(draft, folder=folder), folder)
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider",
                   "--hri-diagnose=0", *options]  # fmt: skip
        text, is_ended = _run_command(command, folder)
        report = folder / "hri-report" / "report.json"
        if not report.exists():
            return _Session(text, is_ended, None)
        raised_at = _error_location(report, folder, Path(draft.code.root))
        return _Session(text, is_ended, json.loads(report.read_text(encoding="utf-8")), raised_at)


def run(draft: Draft, suite: str, tests: int | None = None) -> FirstRuns:
    """Run one suite of a draft, or so many of its tests."""
    options = [f"--hri-suite={suite}"]
    options += [] if tests is None else [f"--hri-tests={tests}", "--hri-audit=off"]
    session = _session(draft, options)
    if session.report is None:
        return FirstRuns(0, 0, (), (), _last_error(session.text))
    waived = _WAIVED.search(session.text)
    trial = replace(_read(session.report), raised_at=session.raised_at,
                    no_waivers=waived.group(1) if waived else "")  # fmt: skip
    return replace(trial, never=(), is_ended=True) if session.is_ended else trial


def _run_command(command: Sequence[str], folder: Path) -> tuple[str, bool]:
    """What a command says; and whether it was ended, as a session that still reports what it has."""
    process = subprocess.Popen(
        command, cwd=folder, env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}, text=True,
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )  # fmt: skip
    begin_s = time.monotonic()
    while time.monotonic() - begin_s < LONGEST_S and _processor_s(process.pid) < LIMIT_S:
        try:
            return process.communicate(timeout=POLL_S)[0], False
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


def _read(report: dict[str, Any]) -> FirstRuns:
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
    return FirstRuns(
        len(tests), passed, tuple(failed), tuple(never), _sentence(errors[0]) if errors else "",
        unrepeatable=f"{others[0]['cause']}: {others[0]['detail']}" if others else "",
        leaks=any(other["left_by"] for other in others), raised=len(errors),
        ends=tuple(dict.fromkeys(end for test in tests for end in _ALLOW.findall(test["failure"] or ""))),
    )  # fmt: skip


def _error_location(report: Path, folder: Path, root: Path) -> CodeLine | None:
    """The last line of a failure that pytest names, where it is of the code."""
    for test in json.loads(report.read_text(encoding="utf-8"))["tests"]:
        if test["failure"] and not _is_of_requirements(test):
            for file, line in reversed(re.findall(r"^(\S+\.py):(\d+): ", test["failure"], re.MULTILINE)):
                path = (folder / file).resolve()
                if path.is_relative_to(root) and not path.is_relative_to(folder):
                    return CodeLine(path.relative_to(root).as_posix(), int(line))
            return None
    return None


def _sentence(failure: str) -> str:
    """What was raised, without the way to it; the last one where it was raised while another was handled."""
    last = re.split(r"^(?:The above exception was|During handling of the above)", failure, flags=re.MULTILINE)[-1]
    raised = [line[1:].strip() for line in last.splitlines() if line.startswith("E ")]
    return (raised[0] if raised else failure.strip().splitlines()[0])[:600]


def _is_of_requirements(test: dict[str, Any]) -> bool:
    return any(result["failures"] for result in test["requirements"].values())


# --- what they settle


_REMEDY = "what do the stand-ins of `ports.py` have to return there?"
"""What to do where the first runs raise."""

_NODE_REMEDY = "which fields does `said` in `conftest.py` send it, and what do others answer?"
"""The same where the code is a node of ROS 2."""


def remedy(draft: Draft, trial: FirstRuns) -> str:
    """What to do where the first runs of a draft raise.

    What the code raises in some of them, and not in the others, most often is a fault of the code.
    """
    stand_ins = _REMEDY if draft.ros is None else _NODE_REMEDY
    if trial.raised_at is None or not 0 < trial.raised < trial.tests:
        return stand_ins
    share = f"{trial.raised} of {trial.tests} tests end so"
    return f"{share}: a fault of the code, for what it receives in them (`pytest` shows it)? if not, {stand_ins}"


def settle(draft: Draft, suites: Sequence[str] = SUITES) -> tuple[Draft, tuple[FirstRuns, ...]]:
    """The draft after its first runs: requirements that do not hold are questions in it.

    A draft whose runs loop without time passing is run once more with devices that take time, and one whose tests leave
    a state to each other with a process for each test. Runs may end as they did, and in no other way.
    """
    trials: list[FirstRuns] = []
    draft = replace(draft, allowed_endings=())
    if "rl" in suites:
        draft = _run_few(draft)
    for suite in suites:
        draft, trial = _run_suite(draft, suite)
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


def _run_few(draft: Draft) -> Draft:
    """The draft after few tests, as all of them would take long where much fails."""
    draft, first = _run_to_ends(draft, "rl", FIRST_TESTS)
    if first.error and "no simulated time" not in first.error and draft.has_others:
        without_others, known = _run_to_ends(replace(draft, has_others=False), "rl", FIRST_TESTS)
        if not known.error:  # the code raises for a text that it does not know
            draft, first = without_others, known
    draft = replace(draft, takes_time="no simulated time" in first.error)
    return without(draft, first.failed)


def _run_suite(draft: Draft, suite: str) -> tuple[Draft, FirstRuns]:
    """The runs of a suite, and the draft with what they need to end, and to repeat."""
    draft, trial = _run_to_ends(draft, suite)
    if trial.error and "no simulated time" in trial.error and not draft.takes_time:
        draft, trial = _run_to_ends(replace(draft, takes_time=True), suite)
    if trial.leaks and not draft.isolates:
        draft, trial = _run_to_ends(replace(draft, isolates=True), suite)
    return draft, trial


def _run_to_ends(draft: Draft, suite: str, tests: int | None = None) -> tuple[Draft, FirstRuns]:
    """The runs of a suite, and the draft that allows how they end, and waives nothing that they executed."""
    trial = run(draft, suite, tests)
    while ends := set(trial.ends) - set(draft.allowed_endings):
        draft = replace(draft, allowed_endings=tuple(end for end in ENDS if end in (*draft.allowed_endings, *ends)))
        trial = run(draft, suite, tests)
    return replace(draft, no_waivers=draft.no_waivers or trial.no_waivers), trial


def _with_problems(draft: Draft, trials: Sequence[FirstRuns]) -> Draft:
    """The draft with what the runs have shown that somebody has to fix."""
    raised = tuple(
        Problem("raised", f"{_one_line(trial.error)}: the draft is not green; {remedy(draft, trial)}", trial.raised_at)
        for trial in trials
        if trial.error
    )
    differing = tuple(
        Problem("unrepeatable", f"a run does not repeat ({reason}): the draft is not green", None)
        for reason in dict.fromkeys(trial.unrepeatable for trial in trials if trial.unrepeatable)
    )
    code = draft.code
    return replace(draft, code=replace(code, problems=code.problems + raised + differing))


def _one_line(text: str) -> str:
    return " ".join(text.split())


def without(draft: Draft, names: Sequence[str]) -> Draft:
    """The draft, in which these requirements are questions."""
    subjects = {name: subject for subject, name in requirement_ids(draft).items()}
    dropped = tuple(subjects[name] for name in names if name in subjects)
    made = replace(draft, dropped=tuple(dict.fromkeys(draft.dropped + dropped)))
    return replace(made, has_dropped_all=made.has_dropped_all or {*subjects.values()} <= {*made.dropped})
