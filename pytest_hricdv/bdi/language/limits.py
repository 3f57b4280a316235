"""Resource limits of a model's run, in steps and sizes, never in time, so that they are the same on every machine.

Rules, lists and messages may grow without end within one reasoning cycle. Their loops count work with `spend`, and a
run that does too much of it ends with a `LimitError`. Ordinary reasoning cycles are not counted: the limit of rounds
bounds them. Each `SystemRun` has a counter of its own (`count_work`).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol, TypeVar

from pytest_hricdv.bdi.language.errors import BdiError

Item = TypeVar("Item")

MAX_WORK = 10_000_000
"""Most units of work of a run (a unit takes one to four microseconds, `pytest -m slow tests/bdi/run/test_limits.py
--durations=0`, so a run ends within a minute)."""
WORK_PER_CYCLE = 50
"""Units of work that a run may do in addition for each agent and round: about the work of the cycle itself."""
MAX_SIZE = 1_000_000
"""Most terms in a term, each as often as it occurs (100 MB if no two of them are the same object)."""
MAX_ANSWERS = 1_000_000
"""Most answers of a query that are kept at once, as by ``.findall`` (400 MB in a ``for`` loop)."""
MAX_HELD = 1_000_000
"""Most beliefs of all agents (up to 1 kB each, 1 GB in all); the same limit holds for plans and for pending events."""
CHARACTERS = 16
"""Characters that count as one term, or one unit of work (10 million units are 160 MB)."""
ITEMS = 16
"""Items of a list that can be copied in a unit of work (60 ns each)."""
ROUNDS_BETWEEN_COUNTS = 1024
"""Rounds between two counts of beliefs and pending events (a count of a million beliefs takes 20 ms)."""
_OUTSIDE = 1 << 62
"""The units of work left outside of runs: more than anything takes, so there is no limit."""


class LimitError(BdiError):
    """A run has reached a limit; the run adds which agent and plan did.

    Attributes:
        rule: the rule that was used last, as text with its place; empty if none was.
    """

    rule = ""


class _Work:
    """The work that the present run may still do (units); one number for all, because terms know no run."""

    __slots__ = ("left",)

    def __init__(self) -> None:
        self.left = _OUTSIDE


WORK = _Work()


class WorkCounter(Protocol):
    """A run whose work is counted."""

    work_left: int


def spend(units: int) -> None:
    """Count work, before it is done. Raises LimitError: the run has done too much."""
    WORK.left -= units
    if WORK.left < 0:
        raise too_much_work()


def too_much_work() -> LimitError:
    """The error of a run that has done too much."""
    return LimitError(f"does not come to an end within {MAX_WORK:,} steps")


@contextmanager
def count_work(run: WorkCounter) -> Iterator[None]:
    """Count the work done inside as the run's; runs may be nested."""
    outside, WORK.left = WORK.left, run.work_left
    try:
        yield
    finally:
        run.work_left, WORK.left = WORK.left, outside


def is_even(work: int, rounds: int, max_rounds: int) -> bool:
    """Whether a run that does as much work in all its rounds is far from the limit, so that its parts need no sum."""
    return 2 * (work - WORK_PER_CYCLE * rounds) * max_rounds <= MAX_WORK * rounds


def too_large() -> LimitError:
    """The error of a term that is too large."""
    return LimitError(f"makes a term of more than {MAX_SIZE:,} parts")


def limit_answers(answers: Iterator[Item]) -> Iterator[Item]:
    """Answers that are kept. Raises LimitError: there are too many."""
    for number, answer in enumerate(answers):
        if number >= MAX_ANSWERS:
            raise LimitError(f"has more than {MAX_ANSWERS:,} answers")
        yield answer


def check_text(characters: int) -> None:
    """Count the work for a text before it is made. Raises LimitError: it is too long, or the run has done too much."""
    if characters > MAX_SIZE * CHARACTERS:
        raise LimitError(f"makes a string of more than {MAX_SIZE * CHARACTERS:,} characters")
    spend(characters // CHARACTERS)
