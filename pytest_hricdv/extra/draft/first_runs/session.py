"""A session of pytest of a draft, in a folder and a process of its own: how tests ended, and what they executed."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, pairwise
from pathlib import Path
from typing import Any

from pytest_hricdv.extra.draft.first_runs import guard
from pytest_hricdv.extra.draft.first_runs.dialogs import AT_END, CODE, TEXT, WAITS, Dialog, Reached, text_of
from pytest_hricdv.extra.draft.found.findings import Place, Problem
from pytest_hricdv.extra.draft.writing.drafted import Draft
from pytest_hricdv.extra.draft.writing.model import UNTIL_QUIET, leaves
from pytest_hricdv.extra.draft.writing.project import write

LIMIT_S = 90.0
"""Processor time of the first runs of a suite (chosen: nobody waits for longer for a draft); then they are ended. It
is not the time of the clock, so that a busy machine drafts the same."""

LONGEST_S = 600.0
"""So long by the clock, where nothing says the processor time, or nothing is computed (chosen)."""

LOOKS_EACH_S = 0.5
"""How often the processor time is looked at (chosen: a session takes several seconds)."""

ENDING_S = 30.0
"""So long a session that was told to end may take for its report (chosen)."""

_NUMBER = re.compile(r"\d+([.]\d+)?")
"""Texts that differ only in these are of one situation: `battery 37 %`."""

_WAIVED = re.compile(r"(\S+\.py:\d+): ran, though it is waived")
"""What a session says where the code has a wrong waiver."""

_ALLOW = re.compile(r'may_end=\("(\w+)",\)')
"""What a failure says that the testbench would have to allow."""


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
        reached: what the tests executed.
        no_waivers: where they executed what the code waives as unreachable, `file:line`; empty where they did not.
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
    reached: Reached = frozenset()
    no_waivers: str = ""


@dataclass(frozen=True)
class _Session:
    """What a session of a draft said, its report if there is one, what the code did outside, and where it raised."""

    text: str
    is_ended: bool
    report: dict[str, Any] | None
    effects: tuple[Problem, ...]
    raised_at: Place | None = None


def _session(draft: Draft, options: Sequence[str], texts: Mapping[str, str] | None = None) -> _Session:
    """Run pytest in a folder with a draft, and further files."""
    with tempfile.TemporaryDirectory(prefix="hri-draft-") as name:
        folder = Path(name).resolve()
        write(replace(draft, folder=folder), folder)
        for file, text in (texts or {}).items():
            (folder / file).write_text(text, encoding="utf-8")
        notes = folder / "effects.txt"
        environment = {
            **os.environ,
            guard.ROOT: draft.findings.root,
            guard.NOTES: str(notes),
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        command = [sys.executable, "-m", "pytest", "-q", "-p", guard.__name__, "-p", "no:cacheprovider",
                   "--hri-diagnose=0", *options]  # fmt: skip
        text, is_ended = _done(command, folder, environment)
        report = folder / "hri-report" / "report.json"
        if not report.exists():
            return _Session(text, is_ended, None, _effects(notes))
        raised_at = _raised_at(report, folder, Path(draft.findings.root))
        return _Session(text, is_ended, json.loads(report.read_text(encoding="utf-8")), _effects(notes), raised_at)


def run(draft: Draft, suite: str, tests: int | None = None) -> Trial:
    """Run one suite of a draft, or so many of its tests."""
    options = [f"--hri-suite={suite}"]
    options += [] if tests is None else [f"--hri-tests={tests}", "--hri-audit=off"]
    session = _session(draft, options)
    if session.report is None:
        return Trial(0, 0, (), (), _last_error(session.text), session.effects)
    waived = _WAIVED.search(session.text)
    trial = replace(_read(session.report, session.effects), raised_at=session.raised_at,
                    no_waivers=waived.group(1) if waived else "")  # fmt: skip
    return replace(trial, never=(), is_ended=True) if session.is_ended else trial


def covered(draft: Draft, dialogs: Sequence[Dialog]) -> dict[Dialog, Reached]:
    """What dialogs execute, without those in which the code raises; nothing where they take too long.

    After each of them the person stays until the robot is done, where one can tell.
    """
    ended = [(*dialog, UNTIL_QUIET) if leaves(draft) else dialog for dialog in dialogs]
    options = ["--hri-suite=dialogs.txt", f"--hri-tests={len(dialogs)}", "--hri-audit=off"]
    session = _session(draft, options, {"dialogs.txt": text_of(ended)})
    if session.report is None or session.is_ended:
        return {}
    tests = [test for test in session.report["tests"] if not test["failure"] or _is_of_requirements(test)]
    return {tuple(step for step in test["abstract"] if step != UNTIL_QUIET): reached_in(test) for test in tests}


def reached_in(test: Mapping[str, Any]) -> Reached:
    """What a test of a report came to. A run that raised at once has no timeline, and one without texts none of them.

    Situations show the way where no new statement does: to be told where to go means more when the lid is open.
    """
    measured: Mapping[str, Any] = test.get("code") or {}
    bits = [f"{int(number, 16):b}"[::-1] for number in measured.get("bits", ())]
    code = {f"{kind} {n}" for kind, those in zip(CODE, bits, strict=False)
            for n, bit in enumerate(those) if bit == "1"}  # fmt: skip
    timeline: Mapping[str, Any] = test.get("timeline") or {}
    texts: Mapping[str, Sequence[tuple[float, str]]] = timeline.get("texts", {})
    changes = {f"{TEXT} {name}: {_alike(before)} -> {_alike(text)}"
               for name, values in texts.items() for (_, before), (_, text) in pairwise(values)}  # fmt: skip
    acted = zip(test.get("acted_s") or (), test.get("abstract") or (), strict=False)
    waits_s = max((time_s for time_s, step in acted if step == WAITS), default=0.0)
    return frozenset({*code, *changes, *_situations(texts, waits_s)})


def _alike(text: str) -> str:
    """The text without its numbers."""
    return _NUMBER.sub("#", text)


def _situations(texts: Mapping[str, Sequence[tuple[float, str]]], waits_s: float) -> Iterator[str]:
    """All that texts are at one time; and what they are when a last wait, which begins at `waits_s`, is answered."""
    changes = sorted((time_s, name, text) for name, values in texts.items() for time_s, text in values)
    now: dict[str, str] = {}
    end, is_over = "", False
    for time_s, at_once in groupby(changes, key=lambda change: change[0]):
        now |= {name: _alike(text) for _, name, text in at_once}
        situation = json.dumps(now, sort_keys=True)
        yield situation
        end, is_over = (end, True) if is_over else (situation, time_s >= waits_s)
    yield f"{AT_END} {end}"


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
        reached=frozenset().union(*map(reached_in, tests)),
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
    """What was raised, without the way to it; the last one where it was raised while another was handled."""
    last = re.split(r"^(?:The above exception was|During handling of the above)", failure, flags=re.MULTILINE)[-1]
    raised = [line[1:].strip() for line in last.splitlines() if line.startswith("E ")]
    return (raised[0] if raised else failure.strip().splitlines()[0])[:600]


def _is_of_requirements(test: dict[str, Any]) -> bool:
    return any(result["failures"] for result in test["requirements"].values())
