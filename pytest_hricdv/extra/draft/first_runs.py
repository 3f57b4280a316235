"""The first runs of a draft, in their own process and folder."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pytest_hricdv.extra.draft.code_model import CodeLine
from pytest_hricdv.extra.draft.observe.observations import Observations, read_observations
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.files import write
from pytest_hricdv.extra.draft.stand_ins.border import OBSERVE

WALL_FACTOR = 10.0
"""Wall time that runs may take of each second of their processor time: a busy machine makes the same draft."""

HOLLOW = "nothing that people"
"""How the problem of a session begins in which nothing reached the code."""

MIN_SHARE = 0.5
"""Of the tests, that trigger a requirement: a session of a dozen tests misses it once in 4,000 times."""

POLL_S = 0.5
"""Period at which the processor time is read."""

ENDING_S = 30.0
"""Time that a terminated session gets to write its report."""

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
        rare: ids of requirements that few of the tests triggered.
        error: what the code raised or the testbench lacks, in a sentence; empty if all runs completed.
        raised_at: the line of the code that raised; None if none did.
        is_ended: whether the runs took too long; the draft then has as many tests as had run.
        unrepeatable: why a test behaved differently when rerun alone in a fresh process; empty if none did.
        leaks: whether the reason is state that a test left behind.
        raised: number of tests that ended with an error.
        ends: endings that occurred and that the testbench does not allow (`allowed_endings`).
        no_waivers: lines executed although the code waives them as unreachable, as `file:line`.
        raising: commands of each test that ended with an error. calm: those of each other test.
        libraries: top-level names of the modules that the code was in when it raised.
        hollow: why the session fails though no test does: nothing reached the code; empty if something did.
        used_s: processor time of the runs (s).
        seen: what the stand-ins observed.
        missing: lines of the code that no test executed, by file.
    """

    tests: int
    passed: int
    failed: tuple[str, ...]
    rare: tuple[str, ...]
    error: str
    raised_at: CodeLine | None = None
    is_ended: bool = False
    unrepeatable: str = ""
    leaks: bool = False
    raised: int = 0
    ends: tuple[str, ...] = ()
    no_waivers: str = ""
    raising: tuple[frozenset[str], ...] = ()
    calm: tuple[frozenset[str], ...] = ()
    libraries: frozenset[str] = frozenset()
    hollow: str = ""
    used_s: float = 0.0
    seen: Observations | None = None
    missing: Mapping[str, tuple[int, ...]] = field(default_factory=dict)


@dataclass(frozen=True)
class _Session:
    """What a session of a draft said, its report if there is one, and what it took (s of processor time)."""

    text: str
    is_ended: bool
    report: dict[str, Any] | None
    used_s: float
    seen: Observations | None = None
    raised_at: CodeLine | None = None


def _session(draft: Draft, options: Sequence[str], limit_s: float) -> _Session:
    """Run pytest in a folder with a draft."""
    with tempfile.TemporaryDirectory(prefix="hri-draft-") as name:
        folder = Path(name).resolve()
        write(replace(draft, folder=folder), folder)
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider",
                   "--hri-diagnose=0", *options]  # fmt: skip
        observed = folder / "observed.json"
        text, is_ended, used_s = _run_command(command, folder, observed, limit_s)
        seen = read_observations(observed) if observed.exists() else None
        report = folder / "hri-report" / "report.json"
        if not report.exists():
            return _Session(text, is_ended, None, used_s, seen)
        raised_at = _error_location(report, folder, Path(draft.code.root))
        content = json.loads(report.read_text(encoding="utf-8"))
        return _Session(text, is_ended, content, used_s, seen, raised_at)


def run(draft: Draft, suite: str, limit_s: float, tests: int | None = None) -> FirstRuns:
    """Run one suite of a draft, or so many of its tests, for at most so many seconds of processor time."""
    options = [f"--hri-suite={suite}"]
    options += [] if tests is None else [f"--hri-tests={tests}", "--hri-audit=off"]
    session = _session(draft, options, limit_s)
    if session.report is None:
        reason = _last_error(session.text) or "they took too long"
        return FirstRuns(0, 0, (), (), reason, used_s=session.used_s, seen=session.seen,
                         libraries=_libraries(session.text), is_ended=session.is_ended)  # fmt: skip
    waived = _WAIVED.search(session.text)
    trial = replace(_read(session.report), raised_at=session.raised_at, no_waivers=waived.group(1) if waived else "",
                    used_s=session.used_s, seen=session.seen)  # fmt: skip
    return replace(trial, is_ended=session.is_ended)


def _run_command(command: Sequence[str], folder: Path, observed: Path, limit_s: float) -> tuple[str, bool, float]:
    """What a command says; whether it was ended, as a session that still reports what it has; and what it took."""
    process = subprocess.Popen(
        command, cwd=folder, env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1", OBSERVE: str(observed)}, text=True,
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, errors="replace",
    )  # fmt: skip
    begin_s, used_s = time.monotonic(), 0.0
    while time.monotonic() - begin_s < WALL_FACTOR * limit_s and used_s < limit_s:
        try:
            text = process.communicate(timeout=POLL_S)[0]
            return text, False, max(used_s, min(time.monotonic() - begin_s, used_s + POLL_S))
        except subprocess.TimeoutExpired:
            used_s = max(used_s, _processor_s(process.pid))
    process.terminate()
    try:
        return process.communicate(timeout=ENDING_S)[0], True, used_s
    except subprocess.TimeoutExpired:
        process.kill()
        return process.communicate()[0], True, used_s


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
    tests_of: dict[str, int] = dict.fromkeys(report["requirements"], 0)
    for test in tests:
        for name, result in test["requirements"].items():
            if result["failures"]:
                failed[name] = None
            tests_of[name] = tests_of.get(name, 0) + bool(result["triggers"])
    rare = [name for name, count in tests_of.items() if count < MIN_SHARE * len(tests)]
    errors = [test["failure"] for test in tests if test["failure"] and not _is_of_requirements(test)]
    passed = sum(test["outcome"] == "passed" for test in tests)
    others = [test["unrepeatable"] for test in tests if test.get("unrepeatable")]
    return FirstRuns(
        len(tests), passed, tuple(failed), tuple(rare), _sentence(errors[0]) if errors else "",
        unrepeatable=f"{others[0]['cause']}: {others[0]['detail']}" if others else "",
        leaks=any(other["left_by"] for other in others), raised=len(errors),
        ends=tuple(dict.fromkeys(end for test in tests for end in _ALLOW.findall(test["failure"] or ""))),
        raising=tuple(_commands(test) for test in tests if _has_raised(test)),
        calm=tuple(_commands(test) for test in tests if not _has_raised(test)),
        libraries=frozenset(name for test in tests if _has_raised(test) for name in _libraries(test["failure"])),
        hollow=next((text for text in report.get("problems", {}).get("failed", ()) if text.startswith(HOLLOW)), ""),
        missing={file["file"]: tuple(file["missing_lines"])
                 for file in (report.get("code_under_test") or {}).get("files", ())},
    )  # fmt: skip


def _has_raised(test: dict[str, Any]) -> bool:
    return bool(test["failure"]) and not _is_of_requirements(test)


def _commands(test: dict[str, Any]) -> frozenset[str]:
    """What was said in a test, and what was set."""
    return frozenset(command if command.startswith("set_") else command.rpartition(" ")[0] or command
                     for command in test.get("abstract") or ())  # fmt: skip


_INSTALLED = re.compile(r"site-packages/(\w+)|lib/python3\.\d+/(\w+)\.py")


def _libraries(failure: str) -> frozenset[str]:
    """The modules outside the code that a traceback goes through, without those that run the tests."""
    names = {first or second for first, second in _INSTALLED.findall(failure)}
    return frozenset(names - {"site", "pytest_hricdv", "_pytest", "pytest", "pluggy", "greenlet", "python3"})


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
