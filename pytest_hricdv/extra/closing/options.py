"""Options of the closing loop."""

from __future__ import annotations

from dataclasses import dataclass

NAME = "closure"
"""The method, and its suite."""


@dataclass(frozen=True)
class ClosingOptions:
    """Whether there is a closing loop, and its budget.

    Args:
        asked: there is one.
        others: the suites beside it, as they were named.
        given: it closes what these leave open, instead of everything.
        runs: it ends after so many runs.
        seconds: it ends after this time (s), so that a session is not endless: its result then depends on the machine.
        without: the names of ways that are left out.
    """

    asked: bool = False
    others: str = ""
    given: bool = False
    runs: int = 400
    seconds: int = 600
    without: tuple[str, ...] = ()


def read_closing(suites: str, *, close: bool, runs: int, seconds: int, without: str) -> ClosingOptions:
    """The options, from the names of suites and the others."""
    names = _names(suites)
    others = [name for name in names if name != NAME]
    asked = close or len(others) < len(names)
    return ClosingOptions(
        asked=asked,
        others=",".join(others) if asked else suites,
        given=close and bool(others),
        runs=runs,
        seconds=seconds,
        without=_names(without),
    )


def _names(text: str) -> tuple[str, ...]:
    return tuple(name for name in (part.strip() for part in text.split(",")) if name)
