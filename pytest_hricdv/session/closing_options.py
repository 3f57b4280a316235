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
    """

    asked: bool = False
    others: str = ""
    given: bool = False
    runs: int = 400
    seconds: int = 600


def read_closing(suites: str, *, close: bool, runs: int, seconds: int) -> ClosingOptions:
    """The options, from the names of suites and the others."""
    names = [name for name in (part.strip() for part in suites.split(",")) if name]
    others = [name for name in names if name != NAME]
    asked = close or len(others) < len(names)
    return ClosingOptions(
        asked=asked,
        others=",".join(others) if asked else suites,
        given=close and bool(others),
        runs=runs,
        seconds=seconds,
    )
