"""`QUESTIONS.md`: what the code does not say, at most ten questions, the first ones with most coverage behind them."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path

from pytest_hricdv.extra.draft.analysis import NO_INPUTS
from pytest_hricdv.extra.draft.code.sources import find_around
from pytest_hricdv.extra.draft.code_model import CodeLine, Question
from pytest_hricdv.extra.draft.project.draft import Draft

MAX_QUESTIONS = 10

HEAD = """\
# Questions

What the code of {robot} does not say. Each question has the line of the code that asks it, and the line of the draft
to edit. The first ones have most unexecuted lines of code behind them. Delete what is answered.
"""

MAX_SUBJECTS = 12
"""Requirements that are listed in a question; `requirements.toml` has all."""

WHOLE = ("entry", "messages", "run", "inner")
"""Subjects on which all of the code hangs."""


def questions_file(draft: Draft, conftest: str) -> str:
    """The content of `QUESTIONS.md`.

    Args:
        draft: the draft.
        conftest: the text of its testbench, in which the lines to edit are looked up.
    """
    ranked = sorted(dict.fromkeys(_questions(draft)), key=lambda question: -_weight(draft, question))
    lines = [HEAD.format(robot=draft.robot)]
    for number, question in enumerate(ranked[:MAX_QUESTIONS], 1):
        weight = _weight(draft, question)
        behind = f" ({weight} lines of code were not executed there)" if weight else ""
        code = f"\n   - code: `{question.location}`{behind}" if question.location is not None else behind
        lines.append(f"{number}. {question.text}{code}\n   - edit: {_edit(question, conftest)}")
    if len(ranked) > MAX_QUESTIONS:
        lines.append(f"\n{len(ranked) - MAX_QUESTIONS} more are less urgent: `TODO` in the files marks them.")
    return "\n".join(lines) + "\n"


def _questions(draft: Draft) -> Iterator[Question]:
    for question in draft.code.questions:
        is_answered = question.text.startswith(NO_INPUTS) and bool(draft.code.inputs or draft.sensors)
        if not is_answered:
            yield question
    if draft.dropped:
        listed = ", ".join(f"*{subject}*" for subject in draft.dropped[:MAX_SUBJECTS])
        more = f", and {len(draft.dropped) - MAX_SUBJECTS} more" if len(draft.dropped) > MAX_SUBJECTS else ""
        text = f"Which of these are required? They did not hold in the first runs, or few tests checked them: {listed}"
        yield Question(text + more, "requirements", None)


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
