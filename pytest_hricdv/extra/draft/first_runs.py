"""`run`: runs tests of a draft in their own process and folder; `FirstRuns` is what their report says."""

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
from pytest_hricdv.extra.draft.observe.shape import MAX_LENGTH
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.files import write
from pytest_hricdv.extra.draft.stand_ins.border import OBSERVE

HOLLOW = "nothing that people"
"""How the report's problem begins if nothing in a session reached the code."""

TOO_LONG = "no test came to its end in time"
"""The error of runs that took too long."""

MIN_SHARE = 0.5
"""Share of the tests that must trigger a requirement: a session of a dozen tests then misses it once in 4,000 times."""

ENDING_S = 15.0
"""Time that a terminated session gets to write its report."""

_EXCEPTION = re.compile(r"[A-Za-z_][\w.]*(?::|$)")
"""A line that names an exception, at the end of a traceback."""

_HEARD = re.compile(r"node robot hears (\w+) raised")
"""The message at which the code raised."""

_ALLOW = re.compile(r'allowed_endings=\("(\w+)",\)')
"""The end of a run that the testbench would have to allow, in the message of a failure."""


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
        ends: endings that occurred and that the testbench does not allow (`allowed_endings`).
        raising: commands of each test that ended with an error. calm: those of each other test.
        last: the last command of each test that ended with an error.
        libraries: top-level names of the modules that the code was in when it raised.
        problems: why the session fails besides its tests and requirements, a sentence each.
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
    ends: tuple[str, ...] = ()
    raising: tuple[frozenset[str], ...] = ()
    calm: tuple[frozenset[str], ...] = ()
    last: tuple[str, ...] = ()
    libraries: frozenset[str] = frozenset()
    problems: tuple[str, ...] = ()
    used_s: float = 0.0
    seen: Observations | None = None
    missing: Mapping[str, tuple[int, ...]] = field(default_factory=dict)

    @property
    def is_hollow(self) -> bool:
        """Whether the session fails because nothing reached the code."""
        return any(problem.startswith(HOLLOW) for problem in self.problems)

    @property
    def cause(self) -> str:
        """The obstacle to a passing session, requirements aside; empty if there is none."""
        return self.error or self.unrepeatable or next(iter(self.problems), "")


@dataclass(frozen=True)
class _Session:
    """The output of a draft's session, its report if there is one, and its processor time (s)."""

    text: str
    status: int | None
    """None if it was ended."""
    report: dict[str, Any] | None
    used_s: float
    seen: Observations | None = None
    raised_at: CodeLine | None = None
    error: str = ""
    """The error that kept it from its tests."""


def _session(draft: Draft, options: Sequence[str], limit_s: float) -> _Session:
    """Run pytest in a folder with a draft."""
    with tempfile.TemporaryDirectory(prefix="hri-draft-") as name:
        folder = Path(name).resolve()
        write(replace(draft, folder=folder), folder)
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider",
                   "--hri-diagnose=0", *options]  # fmt: skip
        observed, root = folder / "observed.json", Path(draft.code.root)
        text, status, used_s = _run_command(command, folder, observed, limit_s)
        seen = read_observations(observed) if observed.exists() else None
        report = folder / "hri-report" / "report.json"
        if not report.exists():
            error = TOO_LONG if status is None else _shorten(_last_error(text), folder, root)
            return _Session(text, status, None, used_s, seen, _line_of(error, root), error)
        raised_at = _error_location(report, folder, root)
        content = json.loads(report.read_text(encoding="utf-8"))
        if draft.ros is not None:
            seen = _texts_on_topics(content)
        for test in content["tests"]:
            test["failure"] = _shorten(test["failure"], folder, root)
        return _Session(text, status, content, used_s, seen, raised_at)


def run(draft: Draft, suite: str, limit_s: float, tests: int | None = None) -> FirstRuns:
    """Run one suite of a draft, or a number of its tests, within a limit of processor time (s)."""
    options = [f"--hri-suite={suite}"]
    options += [] if tests is None else [f"--hri-tests={tests}", "--hri-audit=off"]
    session = _session(draft, options, limit_s)
    is_ended = session.status is None
    if session.report is None:
        return FirstRuns(0, 0, (), (), session.error, session.raised_at, used_s=session.used_s, seen=session.seen,
                         libraries=_libraries(session.text), is_ended=is_ended)  # fmt: skip
    trial = replace(_read(session.report), raised_at=session.raised_at, used_s=session.used_s, seen=session.seen)
    if is_ended:
        return replace(trial, is_ended=True, problems=(), error=trial.error or ("" if trial.tests else TOO_LONG))
    if session.status and not (trial.cause or trial.failed or trial.rare):
        return replace(trial, error=f"pytest ended with status {session.status}")
    return trial


def _run_command(command: Sequence[str], folder: Path, observed: Path, limit_s: float) -> tuple[str, int | None, float]:
    """The output of a command; its status, None if it was ended, as a session that reports; its processor time."""
    with tempfile.TemporaryFile() as output:  # no pipe: processes that the code has left would keep it open
        process = subprocess.Popen(
            command, cwd=folder, env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1", OBSERVE: str(observed)},
            stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
        )  # fmt: skip
        status, used_s = _wait(process, limit_s)
        output.seek(0)
        return output.read().decode(errors="replace"), status, used_s


def _wait(process: subprocess.Popen[bytes], limit_s: float) -> tuple[int | None, float]:
    """The status of a process, None if it was ended at its limit; its processor time (s), or that it might have had."""
    begin_s, before_s = time.monotonic(), _children_s()
    share = max(1.0, os.getloadavg()[0] / (os.cpu_count() or 1))  # a busy machine makes the same draft
    status: int | None = None
    try:
        status = process.wait(limit_s * share)
    except subprocess.TimeoutExpired:
        process.terminate()
        try:
            process.wait(ENDING_S * share)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
    return status, max(_children_s() - before_s, (time.monotonic() - begin_s) / share)


def _children_s() -> float:
    """Processor time of all processes that this one has waited for."""
    times = os.times()
    return times.children_user + times.children_system


def _last_error(text: str) -> str:
    """The error that kept a session from its tests."""
    lines = [line for line in text.splitlines() if line.startswith(("ERROR", "E  ", "INTERNALERROR"))]
    return " ".join(lines[-3:])[:600] if lines else text.strip()[-300:]


def _shorten(text: str, folder: Path, root: Path) -> str:
    """A text in which files of the code are relative to its root, and those of the draft to its folder."""

    def relative(found: re.Match[str]) -> str:
        path = Path(found[0]).resolve()
        within = next((parent for parent in (folder, root) if path.is_relative_to(parent)), None)
        return path.relative_to(within).as_posix() if within is not None else str(path)

    return re.sub(rf"{re.escape(str(folder))}[^\s:'\"]+", relative, text)


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
    problems = (*report.get("problems", ()), *(report.get("gates") or {}).get("failed", ()))
    errors = [test["failure"] for test in tests if test["failure"] and not _is_of_requirements(test)]
    passed = sum(test["outcome"] == "passed" for test in tests)
    others = [test["unrepeatable"] for test in tests if test.get("unrepeatable")]
    return FirstRuns(
        len(tests), passed, tuple(failed), tuple(rare), sentence_of(errors[0]) if errors else "",
        unrepeatable=f"{others[0]['cause']}: {others[0]['detail']}" if others else "",
        leaks=any(other.get("left_by") for other in others),
        ends=tuple(dict.fromkeys(end for test in tests for end in _ALLOW.findall(test["failure"] or ""))),
        raising=tuple(_commands(test) for test in tests if _has_raised(test)),
        calm=tuple(_commands(test) for test in tests if not _has_raised(test)),
        last=tuple(_last_command(test) for test in tests if _has_raised(test)),
        libraries=frozenset(name for test in tests if _has_raised(test) for name in _libraries(test["failure"])),
        problems=tuple(text for text in problems if text.partition(" ")[0] not in report["requirements"]),
        missing={file["file"]: tuple(file["missing_lines"])
                 for file in (report.get("code_under_test") or {}).get("files", ())},
    )  # fmt: skip


def _texts_on_topics(report: dict[str, Any]) -> Observations:
    """The texts in fields of topics, as the states of attributes are observed."""
    seen = Observations()
    for test in report["tests"]:
        last: dict[str, str] = {}
        for line in (test.get("timeline") or {}).get("messages", ()):
            _, _, topic, fields = line.split("\t", 3)
            for name, text in json.loads(fields).items():
                if isinstance(text, str) and len(text) <= MAX_LENGTH and last.get(f"{topic}.{name}") != text:
                    seen.add_state(f"{topic}.{name}", last.get(f"{topic}.{name}"), text)
                    last[f"{topic}.{name}"] = text
    return seen


def _has_raised(test: dict[str, Any]) -> bool:
    return bool(test["failure"]) and not _is_of_requirements(test)


def _commands(test: dict[str, Any]) -> frozenset[str]:
    """The messages said and values set in a test."""
    return frozenset(map(_what, test.get("abstract") or ()))


def _last_command(test: dict[str, Any]) -> str:
    """The last message or value before a test ended, of the topic at which the code raised; empty without one."""
    done = [*(test.get("abstract") or ())][: len(test.get("action_times_s") or ())]
    said = [_what(command) for command in reversed(done) if not command.startswith("wait_")]
    topic = next(iter(_HEARD.findall(test["failure"])), "")
    return next((command for command in said if command.startswith(topic)), next(iter(said), ""))


def _what(command: str) -> str:
    return command if command.startswith("set_") else command.rpartition(" ")[0] or command


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


def _line_of(error: str, root: Path) -> CodeLine | None:
    """The last line of the code that an error names."""
    for file, line in reversed(re.findall(r"([^\s:]+\.py):(\d+)", error)):
        if (root / file).exists():
            return CodeLine(file, int(line))
    return None


def sentence_of(failure: str) -> str:
    """The raised error without its traceback; the last one of a chain."""
    last = re.split(r"^(?:The above exception was|During handling of the above)", failure, flags=re.MULTILINE)[-1]
    lines = last.strip().splitlines()
    raised = [line[1:].strip() for line in lines if line.startswith("E ")]
    # The error of a plain traceback is its last line that is not indented, if that names an exception.
    plain = [line for line in lines if _EXCEPTION.match(line)] if "Traceback (most" in last else []
    return (raised[0] if raised else plain[-1] if plain else failure.strip().splitlines()[0])[:600]


def _is_of_requirements(test: dict[str, Any]) -> bool:
    return any(result["failures"] for result in test["requirements"].values())
