"""The first runs of a draft, in a folder and a process of their own: what holds, and what the code does outside."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pytest_hricdv.extra.draft import guard
from pytest_hricdv.extra.draft.drafted import Draft
from pytest_hricdv.extra.draft.findings import Place, Problem
from pytest_hricdv.extra.draft.project import write
from pytest_hricdv.extra.draft.requirements_text import requirement_ids

LIMIT_S = 100.0
"""So long the first runs may take (chosen: nobody waits for longer for a draft); then they are left out."""

SUITES = ("rl", "closure")
"""The suites that are to be green."""


@dataclass(frozen=True)
class Trial:
    """What came of the first runs.

    Args:
        tests: how many there were.
        passed: of them.
        failures: the requirements that failed in some, and those that none triggered; by their ids.
        error: what the code raised or the testbench lacks, in a sentence; empty where all runs went through.
        effects: what the code would have done outside.
    """

    tests: int
    passed: int
    failures: tuple[str, ...]
    error: str
    effects: tuple[Problem, ...]


def tried(draft: Draft, suites: Sequence[str] = SUITES) -> tuple[Draft, tuple[Trial, ...]]:
    """The draft after its first runs: requirements that do not hold are questions in it.

    A draft whose runs go round without time passing is tried once more with devices that take time.
    """
    trials: list[Trial] = []
    for suite in suites:
        trial = run(draft, suite)
        if trial.error and "no simulated time" in trial.error and not draft.takes_time:
            draft = replace(draft, takes_time=True)
            trial = run(draft, suite)
        trials.append(trial)
        subjects = {name: subject for subject, name in requirement_ids(draft).items()}
        failed = tuple(subjects[name] for name in trial.failures if name in subjects)
        draft = replace(draft, dropped=tuple(dict.fromkeys(draft.dropped + failed)))
        if trial.error:
            break
    effects = tuple(dict.fromkeys(effect for trial in trials for effect in trial.effects))
    findings = draft.findings
    return replace(draft, findings=replace(findings, problems=findings.problems + effects)), tuple(trials)


def run(draft: Draft, suite: str) -> Trial:
    """Run one suite of a draft."""
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
                   f"--hri-suite={suite}", "--hri-audit=off"]  # fmt: skip
        try:
            done = subprocess.run(
                command,
                cwd=folder,
                env=environment,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                timeout=LIMIT_S,
            )
        except subprocess.TimeoutExpired:
            return Trial(
                0, 0, (), f"suite {suite}: its runs took more than {LIMIT_S:g} s, and were ended", _effects(notes)
            )
        report = folder / "hri-report" / "report.json"
        if not report.exists():
            return Trial(0, 0, (), _last_error(done.stdout + done.stderr), _effects(notes))
        return _read(json.loads(report.read_text(encoding="utf-8")), _effects(notes))


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
    errors = [test["failure"] for test in tests if test["outcome"] != "passed" and not _is_of_requirements(test)]
    passed = sum(test["outcome"] == "passed" for test in tests)
    return Trial(len(tests), passed, (*failed, *never), _sentence(errors[0]) if errors else "", effects)


def _sentence(failure: str) -> str:
    """What was raised, without the way to it."""
    raised = [line[1:].strip() for line in failure.splitlines() if line.startswith("E ")]
    return (raised[0] if raised else failure.strip().splitlines()[0])[:600]


def _is_of_requirements(test: dict[str, Any]) -> bool:
    return any(result["failures"] for result in test["requirements"].values())
