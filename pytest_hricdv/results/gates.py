"""Gates: the coverage thresholds and exemptions that decide whether a session passes, as they are declared."""

from __future__ import annotations

import datetime
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

KINDS = ("statements", "branches", "plans", "assertions", "cross")
"""Kinds of coverage that have a percentage."""

MUTANTS = "mutants"
THRESHOLDS = (*KINDS, MUTANTS)
"""What thresholds can be given for: coverage, and the share of mutants that the tests notice."""

_LINE = re.compile(r"(?P<requirement>[^\s:]+)(?:\s+until\s+(?P<until>[^\s:]+))?\s*:\s*(?P<reason>.*)\Z", re.DOTALL)


class ThresholdError(ValueError):
    """A threshold is malformed; the text says what was expected."""


@dataclass(frozen=True)
class Threshold:
    """A lower bound, in percent; one `named` on the command line applies to any selection of tests."""

    kind: str
    percent: float
    named: bool = True


def parse_threshold(text: str, *, named: bool = True) -> Threshold:
    """The threshold of a text `KIND=PCT`. Raises ThresholdError for another form, kind or percentage."""
    kind, equals, percentage = text.partition("=")
    kind = kind.strip()
    if not equals or kind not in THRESHOLDS:
        raise ThresholdError(f"{text}: expected KIND=PCT with KIND in {', '.join(THRESHOLDS)}")
    try:
        percent = float(percentage)
    except ValueError:
        raise ThresholdError(f"{text}: expected a percentage, got {percentage!r}") from None
    if not 0 <= percent <= 100:
        raise ThresholdError(f"{text}: expected a percentage from 0 to 100")
    return Threshold(kind, percent, named)


class ExemptionError(ValueError):
    """A line with an exemption is malformed; the text says what was expected."""


@dataclass(frozen=True)
class Exemption:
    """Something about a requirement is tolerated for a reason: for ever, or up to and including a day."""

    requirement: str
    reason: str
    until: datetime.date | None = None

    def expired(self, today: datetime.date) -> bool:
        """Whether its last day is over."""
        return self.until is not None and today > self.until


def parse_exemptions(lines: Iterable[str]) -> dict[str, Exemption]:
    """Requirement -> exemption, from lines `R3: reason` or `R3 until 2027-01-31: reason`.

    Raises:
        ExemptionError: a line of another form, a day that does not exist, or a second line for a requirement.
    """
    found: dict[str, Exemption] = {}
    for line in lines:
        match = _LINE.match(line.strip())
        if match is None or not match["reason"]:
            raise ExemptionError(f"{line!r}: expected 'REQUIREMENT: reason' or 'REQUIREMENT until YYYY-MM-DD: reason'")
        if match["requirement"] in found:
            raise ExemptionError(f"{line!r}: a second line for {match['requirement']}; expected one")
        until = None if match["until"] is None else _day(match["until"], line)
        found[match["requirement"]] = Exemption(match["requirement"], match["reason"], until)
    return found


def _day(text: str, line: str) -> datetime.date:
    try:
        if re.fullmatch(r"\d{4}-\d\d-\d\d", text):
            return datetime.date.fromisoformat(text)
    except ValueError:
        pass  # a 31st of June
    raise ExemptionError(f"{line!r}: {text!r} is no day; expected YYYY-MM-DD")


@dataclass(frozen=True)
class Gates:
    """Coverage thresholds and exemptions of a session.

    Args:
        thresholds: of coverage.
        fail_on_nc: fail when no test triggered a requirement, unless `may_be_nc` exempts it.
        may_be_nc: requirements that need not be triggered.
        known: exemptions for violations; one that has expired fails the session.
        fail_on_change: fail when a test behaves otherwise than in the baseline.
    """

    thresholds: tuple[Threshold, ...] = ()
    fail_on_nc: bool = False
    may_be_nc: Mapping[str, Exemption] = field(default_factory=dict)
    known: Mapping[str, Exemption] = field(default_factory=dict)
    fail_on_change: bool = False
