"""Writes the files of a draft (`write`), which other modules make, and makes `QUESTIONS.md`.

This asks what the code does not say: at most ten questions, first those that keep most lines of code from running;
then it lists what was in the way.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from pytest_hricdv._base import atomic_file
from pytest_hricdv._base.message import list_names
from pytest_hricdv.extra.draft.analysis import NO_INPUTS
from pytest_hricdv.extra.draft.code.sources import DraftError, find_around
from pytest_hricdv.extra.draft.code_model import OWN_MODULE, CodeLine, Question
from pytest_hricdv.extra.draft.project.answers import RECORD, merge, record_text
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.driver import messages_module, own_messages
from pytest_hricdv.extra.draft.project.model import mas2j, meta, person, robot
from pytest_hricdv.extra.draft.project.requirements import requirements
from pytest_hricdv.extra.draft.project.testbench import conftest

MAX_QUESTIONS = 10

HEAD = """\
# Questions

`hricdv init {options}` wrote this folder; again, it keeps what was edited. This is what the code does not say. Each
question has the line of the code that asks it, and the line of the draft to edit. The first ones have most unexecuted
lines of code behind them. Delete what is answered.
"""

MAX_SUBJECTS = 12
"""Requirements that are listed in a question; `requirements.toml` has all."""

WHOLE = ("entry", "messages", "run", "inner")
"""Subjects of questions that keep all of the code from running."""


def questions_file(draft: Draft, conftest: str) -> str:
    """The content of `QUESTIONS.md`; `conftest` is the text in which the lines to edit are looked up."""
    ranked = sorted(dict.fromkeys(_questions(draft)), key=lambda question: -_weight(draft, question))
    options = f"--from {draft.code.package}" if draft.ros is None else f'--ros2 "{draft.ros.asked}"'
    lines = [HEAD.format(options=options), *([f"**Hollow**: {draft.hollow}.\n"] if draft.hollow else [])]
    for number, question in enumerate(ranked[:MAX_QUESTIONS], 1):
        weight = _weight(draft, question)
        behind = f" ({weight} lines of code were not executed there)" if weight else ""
        code = f"\n   - code: `{question.location}`{behind}" if question.location is not None else behind
        lines.append(f"{number}. {question.text}{code}\n   - edit: {_edit(question, conftest)}")
    if len(ranked) > MAX_QUESTIONS:
        lines.append(f"\n{len(ranked) - MAX_QUESTIONS} more are less urgent: `TODO` in the files marks them.")
    if draft.code.problems:
        lines += ["\n## What was in the way\n"]
        lines += [f"- {f'`{p.location}`: ' if p.location is not None else ''}{p.text}" for p in draft.code.problems]
    return "\n".join(lines) + "\n"


def _questions(draft: Draft) -> Iterator[Question]:
    for question in draft.code.questions:
        is_answered = question.text.startswith(NO_INPUTS) and bool(draft.code.inputs or draft.sensors)
        if not is_answered:
            yield question
    if draft.dropped:
        listed = list_names([f"*{subject}*" for subject in draft.dropped], MAX_SUBJECTS)
        text = f"Which of these are required? They did not hold in the first runs, or few tests checked them: {listed}"
        yield Question(text, "requirements", None)


def _weight(draft: Draft, question: Question) -> int:
    """Lines that no first run executed, in the function or class that a question is about."""
    if question.about in WHOLE:
        return sum(map(len, draft.missing.values()))
    location = question.location
    if location is None:
        return 0
    missing = next((lines for file, lines in draft.missing.items() if file.endswith(location.file)), ())
    first, last = _extent(Path(draft.code.root) / location.file, location.line)
    return sum(first <= line <= last for line in missing)


@cache
def _extent(file: Path, line: int) -> tuple[int, int]:
    """First and last line of the innermost function or class around a line."""
    around = find_around(file, line)
    return (around[-1].lineno, around[-1].end_lineno or line) if around else (line, line)


def _edit(question: Question, conftest: str) -> str:
    """The line of the draft that answers a question."""
    if question.about == "requirements":
        return "`requirements.toml`"
    marks = [_mark(question.location), f'"{question.about}"', f'"{question.about.partition(".")[0]}']
    for mark in filter(None, marks):
        for number, line in enumerate(conftest.splitlines(), 1):
            if mark in line:
                return f"`conftest.py:{number}`"
    return "`conftest.py`, the driver" if question.about in WHOLE else "`conftest.py`"


def _mark(location: CodeLine | None) -> str:
    return f"# {location}" if location is not None else ""


_HOST = '''"""The host test: runs once for each generated test."""

from __future__ import annotations

from typing import Any


def test_{robot}(hri_case: Any) -> None:
    """One generated test."""
    hri_case.check(hri_case.run())
'''


_SIZES = """# TODO: more tests and runs reach more, and take longer.
hri_tests = {tests}
hri_close_runs = {runs}
"""
_ISOLATES = """\
# In the first runs a test left a state to the next (a variable of a module?). So each has its own process.
hri_isolate = true
"""
_NO_AUDIT = """\
# In the first runs a test did not repeat, see QUESTIONS.md: something comes from outside a run.
hri_audit = off
"""
_NO_WAIVERS = """\
# What the code waives as unreachable is so in another testbench.
hri_no_waivers = true
"""
_TESTS, _RUNS = 30, 60
"""Tests of the suite `rl`, runs of a closing loop: less than two minutes, with the first runs."""
_NODE_TESTS, _NODE_RUNS = 20, 30
"""These numbers for ROS 2 nodes, whose timers make runs longer."""


def files(draft: Draft) -> Iterator[tuple[str, str]]:
    """Name, relative to the project's folder, and content of each file."""
    testbench = conftest(draft)
    yield "conftest.py", testbench
    if draft.ros is None and own_messages(draft):
        yield f"{OWN_MODULE}.py", messages_module(draft)
    yield f"models/{draft.robot}.mas2j", mas2j(draft)
    yield "models/meta.asl", meta(draft)
    yield f"models/{draft.person}.asl", person(draft)
    if draft.inputs:
        yield "models/robot.asl", robot(draft)
    yield "requirements.toml", requirements(draft)
    yield f"test_{draft.robot}.py", _HOST.replace("{robot}", draft.robot)
    yield "QUESTIONS.md", questions_file(draft, testbench)
    tests, runs = (_TESTS, _RUNS) if draft.ros is None else (_NODE_TESTS, _NODE_RUNS)
    sizes = _SIZES.format(tests=draft.sizes.get("rl", tests), runs=draft.sizes.get("closure", runs))
    ini = sizes + (_ISOLATES if draft.isolates else "") + (_NO_AUDIT if not draft.audits else "")
    ini += _NO_WAIVERS if draft.code.has_waivers else ""
    root = os.path.relpath(draft.code.root, draft.folder)
    if root != ".":
        yield "mypy.ini", f"[mypy]\nmypy_path = {root}\nignore_missing_imports = true\n"
    path = "." if root == "." else f". {root}"
    yield "pytest.ini", f"[pytest]\npythonpath = {path}\nhri_suite = rl\n{ini}"


def check(draft: Draft, folder: Path) -> None:
    """Raises DraftError if a file exists that is of no draft, or a module of the code has the name of a file."""
    for name, _ in files(draft):
        if (folder / name).exists() and name not in draft.earlier:
            raise DraftError(
                f"{folder / name} exists: nothing was written; choose another folder: init FOLDER --from ..."
            )
    taken = {OWN_MODULE, "conftest"} & set(draft.code.modules)
    if taken:
        raise DraftError(f"the code has a module {min(taken)!r}, which is the name of a file of the draft; rename it")


def write(draft: Draft, folder: Path) -> tuple[str, ...]:
    """Write all files, with what somebody has changed in those of the last draft; returns their names.

    Raises:
        DraftError: a file exists, then none is written; or the folder cannot be written.
    """
    texts = dict(files(draft))
    check(draft, folder)
    try:
        for name, text in texts.items():
            atomic_file.write_text(folder / name, merge(*draft.earlier[name], text) if name in draft.earlier else text)
        atomic_file.write_text(folder / RECORD, record_text(texts))
    except OSError as error:
        raise DraftError(f"{folder}: cannot be written: {error.strerror or error}") from None
    return tuple(texts)
