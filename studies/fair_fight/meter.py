"""Writes a line for each run of a tool: processor time so far, size of the input, what was violated, what was covered.

Loaded first of all in each process of a tool (`start/sitecustomize.py`): it stands in for the function that
all of the plugin's parts execute tests with. At the end of the budget it ends the processes of the tool.
"""

from __future__ import annotations

import glob
import json
import os
import re
import signal
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

from pytest_hricdv.execution import case
from pytest_hricdv.generate.concrete import ConcreteTest

JOURNAL, BUDGET, BEFORE = "FIGHT_JOURNAL", "FIGHT_BUDGET_S", "FIGHT_BEFORE_S"
"""Environment variables: the file, the processor time that may be used, and what was used before."""

_execute = case.execute


def kinds(result: case.CaseResult) -> list[str]:
    """What a run violated: requirements by their ids, faults by their text without numbers and paths."""
    return sorted({*result.failed, *map(plain, result.errors)})


def plain(text: str) -> str:
    """The first line of a text, without numbers and folders."""
    return re.sub(r"\d[\d.]*", "N", re.sub(r"\S*/", "", text.partition("\n")[0]))[:80]


def used_s() -> float:
    """Processor time of the tool so far: of its processes, and of their children that have ended."""
    ticks = 0
    for pid in _processes():
        with suppress(OSError), open(f"/proc/{pid}/stat", encoding="utf-8") as file:
            ticks += sum(int(field) for field in file.read().rpartition(")")[2].split()[11:15])
    return ticks / os.sysconf("SC_CLK_TCK") + float(os.environ[BEFORE])


def _processes() -> Iterator[int]:
    """Those with this journal in their environment, whatever session they have begun."""
    mark = f"{JOURNAL}={os.environ[JOURNAL]}\0".encode()
    for path in glob.iglob("/proc/[0-9]*/environ"):
        with suppress(OSError), open(path, "rb") as file:
            if mark in file.read():
                yield int(path.split("/")[2])


def repeatable(given: ConcreteTest, done: ConcreteTest) -> ConcreteTest:
    """The test to be run again: as it became, where people decided during the run; not one that was cut off."""
    return done if len(done.actions) >= len(given.actions) else given


def _note(given: ConcreteTest, result: case.CaseResult) -> None:
    now_s, code = used_s(), result.code
    line = {
        "s": round(now_s, 2),
        "actions": len(result.test.actions),
        "kinds": kinds(result),
        "statements": hex(code.statements) if code is not None else "0x0",
        "branches": hex(code.branches or 0) if code is not None else "0x0",
        "test": repeatable(given, result.test).to_json(),
    }
    file = os.open(os.environ[JOURNAL], os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    try:
        os.write(file, (json.dumps(line) + "\n").encode())
    finally:
        os.close(file)
    if now_s >= float(os.environ[BUDGET]):
        for pid in sorted(_processes(), key=lambda each: each == os.getpid()):
            with suppress(OSError):
                os.kill(pid, signal.SIGKILL)


def execute(settings: case.RunSettings, test: ConcreteTest, *arguments: Any, **options: Any) -> case.CaseResult:
    """As `case.execute`, and note the run."""
    result = _execute(settings, test, *arguments, **options)
    if JOURNAL in os.environ:
        _note(test, result)
    return result


if JOURNAL in os.environ:
    case.execute = execute
