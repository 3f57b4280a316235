"""What the call of a test came to in another process: what is sent of it to the one where pytest has the test."""

from __future__ import annotations

import pickle
import warnings
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import pytest


@dataclass(frozen=True)
class Warned:
    """A warning of a test: it is given again where pytest counts warnings."""

    message: Warning | str
    category: type[Warning]
    filename: str
    lineno: int


@dataclass(frozen=True)
class Answer:
    """What a process sends that has made the call.

    Args:
        report: of the call, as pytest sends reports; None where there is none.
        sections: what the test has written, by phase and kind, for the report of its teardown.
        properties: that the test has recorded.
        warned: its warnings.
        exit: the test has ended the session, with this text and status.
        problem: what went wrong beside the test: an error of a plugin.
    """

    report: dict[str, Any] | None = None
    sections: tuple[tuple[str, str, str], ...] = ()
    properties: tuple[tuple[str, object], ...] = ()
    warned: tuple[Warned, ...] = ()
    exit: tuple[str, int | None] | None = None
    problem: str = ""


def answer_of(item: pytest.Item, report: pytest.TestReport, caught: Iterable[warnings.WarningMessage]) -> Answer:
    """What is sent of a call.

    Args:
        item: that was called.
        report: of the call, with all that plugins attach.
        caught: its warnings.
    """
    data = item.config.hook.pytest_report_to_serializable(config=item.config, report=report)
    return Answer(
        report={key: value for key, value in data.items() if _can_be_sent(value)},
        sections=tuple(item._report_sections),
        properties=tuple(entry for entry in item.user_properties if _can_be_sent(entry)),
        warned=tuple(map(_warned, caught)),
    )


def _warned(caught: warnings.WarningMessage) -> Warned:
    message, category = caught.message, caught.category
    whole = _can_be_sent(message) and _can_be_sent(category)
    return Warned(
        message if whole else str(message), category if whole else UserWarning, caught.filename, caught.lineno
    )


def _can_be_sent(value: object) -> bool:
    """Whether it is the same on the other side of a pipe."""
    try:
        pickle.loads(pickle.dumps(value))
    except Exception:
        return False
    return True
