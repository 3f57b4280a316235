"""Allowances: what a project puts up with for now, each with its reason, and until when."""

from __future__ import annotations

import datetime
import re
from collections.abc import Iterable
from dataclasses import dataclass

_LINE = re.compile(r"(?P<requirement>[^\s:]+)(?:\s+until\s+(?P<until>[^\s:]+))?\s*:\s*(?P<reason>.*)\Z", re.DOTALL)


class AllowanceError(ValueError):
    """A line that allows for something is malformed; the text says what was expected."""


@dataclass(frozen=True)
class Allowance:
    """Something about a requirement is allowed for a reason: for good, or up to and including a day."""

    requirement: str
    reason: str
    until: datetime.date | None = None

    def expired(self, today: datetime.date) -> bool:
        """Whether its last day is over."""
        return self.until is not None and today > self.until


def allowances(lines: Iterable[str]) -> dict[str, Allowance]:
    """Requirement -> allowance, from lines `R3: reason` or `R3 until 2027-01-31: reason`.

    Raises:
        AllowanceError: a line of another form, a day that there is not, or a second line for a requirement.
    """
    found: dict[str, Allowance] = {}
    for line in lines:
        match = _LINE.match(line.strip())
        if match is None or not match["reason"]:
            raise AllowanceError(f"{line!r}: expected 'REQUIREMENT: reason' or 'REQUIREMENT until YYYY-MM-DD: reason'")
        if match["requirement"] in found:
            raise AllowanceError(f"{line!r}: a second line for {match['requirement']}; expected one")
        until = None if match["until"] is None else _day(match["until"], line)
        found[match["requirement"]] = Allowance(match["requirement"], match["reason"], until)
    return found


def _day(text: str, line: str) -> datetime.date:
    try:
        if re.fullmatch(r"\d{4}-\d\d-\d\d", text):
            return datetime.date.fromisoformat(text)
    except ValueError:
        pass  # a 31st of June
    raise AllowanceError(f"{line!r}: {text!r} is no day; expected YYYY-MM-DD")
