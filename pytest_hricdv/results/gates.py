"""`Gates`: thresholds and exemptions that decide whether a session passes, as `session.options` reads them."""

from __future__ import annotations

import datetime
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from pytest_hricdv._base.message import InputError
from pytest_hricdv.results.section import shares

KINDS = ("statements", "branches", "plans", "assertions", "cross")
"""Kinds of coverage that have a percentage."""

MAX_SHARDS = 9_999
"""Greatest number of shards of a session, as a merge lists those that are missing. Chosen: a suite has fewer tests."""

KNOWN = "REQUIREMENT [of CAUSE,...] [when CONDITION] [until YYYY-MM-DD]: reason"
ALLOWED_UNTRIGGERED = "REQUIREMENT [in SUITE,...] [until YYYY-MM-DD]: reason"
"""The forms of a line with an exemption."""

_BEFORE_COLON = re.compile(r"""(?:"[^"]*"|'[^']*'|\[[^\]]*\]|[^:])*""")
_HEAD = re.compile(
    r"(?P<requirement>\S+)(?:\s+in\s+(?P<in>\S+))?(?:\s+of\s+(?P<of>\S+))?"
    r"(?:\s+when\s+(?P<when>.+?))?(?:\s+until\s+(?P<until>\S+))?\s*\Z",
    re.DOTALL,
)

_CAUSE = re.compile(r"[0-9a-f]{8}")


class ThresholdError(InputError, ValueError):
    """A threshold is malformed; the message says what was expected."""


@dataclass(frozen=True)
class Threshold:
    """A lower bound, in percent; a bound `named` on the command line applies to any selection of tests."""

    kind: str
    percent: float
    named: bool = True


def threshold_kinds() -> tuple[str, ...]:
    """The kinds of thresholds: coverage, and the shares that features measure."""
    return (*KINDS, *(share.kind for share in shares()))


def parse_threshold(text: str, *, named: bool = True) -> Threshold:
    """The threshold of a text `KIND=PCT`. Raises ThresholdError for another form, kind or percentage."""
    kind, equals, percentage = text.partition("=")
    kind = kind.strip()
    if not equals or kind not in threshold_kinds():
        raise ThresholdError(f"{text}: expected KIND=PCT with KIND in {', '.join(threshold_kinds())}")
    try:
        percent = float(percentage)
    except ValueError:
        raise ThresholdError(f"{text}: expected a percentage, got {percentage!r}") from None
    if not 0 <= percent <= 100:
        raise ThresholdError(f"{text}: expected a percentage from 0 to 100")
    return Threshold(kind, percent, named)


class ExemptionError(InputError, ValueError):
    """A line with an exemption is malformed; the message says what was expected."""


@dataclass(frozen=True)
class Exemption:
    """Something about a requirement is tolerated for a reason.

    Args:
        requirement: its id.
        reason: for people.
        until: the last day; None for ever.
        condition: text of a condition; a violation is tolerated where it holds at the time of the violation. Empty for
            everywhere.
        suites: where it is tolerated; empty for all.
        causes: ids of the causes for which it is tolerated; empty if none is named.
    """

    requirement: str
    reason: str
    until: datetime.date | None = None
    condition: str = ""
    suites: tuple[str, ...] = ()
    causes: tuple[str, ...] = ()

    def is_expired(self, today: datetime.date) -> bool:
        """Whether its last day is over."""
        return self.until is not None and today > self.until

    @property
    def text(self) -> str:
        """The reason, with causes and the condition if there are any."""
        of = f"of {','.join(self.causes)} " if self.causes else ""
        return f"{of}{xfail_text(self.reason, self.condition)}"


def xfail_text(reason: str, condition: str) -> str:
    """`when state == "Move_hand": no crush prevention`: why, and under which condition, a violation is known."""
    return f"when {condition}: {reason}" if condition else reason


def parse_exemptions(lines: Iterable[str], form: str) -> dict[str, Exemption]:
    """Requirement -> exemption, from lines of this form, as `parse_exemption` reads them.

    Raises:
        ExemptionError: a line of another form, a day that does not exist, or a second line for a requirement.
    """
    exemptions: dict[str, Exemption] = {}
    for line in lines:
        exemption = parse_exemption(line, form)
        if exemption.requirement in exemptions:
            raise ExemptionError(f"{line!r}: a second line for {exemption.requirement}; expected one")
        exemptions[exemption.requirement] = exemption
    return exemptions


def parse_exemption(line: str, form: str, reason: str = "") -> Exemption:
    """The exemption of a line, for instance `R3 when once[0:5](moving) until 2027-01-31: no crush prevention`.

    The reason follows the first colon that is in neither brackets nor quotes.

    Args:
        line: the line of this form.
        form: which clauses it may have, as errors say it: `KNOWN` or `ALLOWED_UNTRIGGERED`.
        reason: where the line has none; empty if it must have one.

    Raises:
        ExemptionError: it has another form, or a day that does not exist.
    """
    head, colon, after = _split(line.strip())
    match = _HEAD.match(head)
    reason = after.strip() or reason
    refused = match is not None and any(
        match[name] and f"[{name} " not in form for name in ("in", "of", "when", "until")
    )
    if match is None and re.match(r"\S+\s.*\bwhile\s", head, re.DOTALL) and "[when " in form:
        raise ExemptionError(f"{line!r}: expected 'when CONDITION' in place of 'while CONDITION'")
    if match is None or refused or not reason or (colon and not after.strip()):
        raise ExemptionError(f"{line!r}: expected 'REQUIREMENT: reason' or '{form}'")
    until = None if match["until"] is None else _day(match["until"], line)
    suites = tuple(filter(None, (match["in"] or "").split(",")))
    return Exemption(match["requirement"], reason, until, match["when"] or "", suites, _causes(match["of"], line))


def _causes(text: str | None, line: str) -> tuple[str, ...]:
    causes = tuple(filter(None, (text or "").split(",")))
    wrong = next((name for name in causes if not _CAUSE.fullmatch(name)), None)
    if wrong is not None:
        raise ExemptionError(
            f"{line!r}: {wrong!r} is not the id of a cause; expected eight of 0-9 and a-f, as reports have it"
        )
    return causes


def _split(line: str) -> tuple[str, str, str]:
    """The text before and after the first colon outside of brackets and quotes."""
    match = _BEFORE_COLON.match(line)
    assert match is not None
    return match[0], line[match.end() : match.end() + 1], line[match.end() + 1 :]


def _day(text: str, line: str) -> datetime.date:
    try:
        if re.fullmatch(r"\d{4}-\d\d-\d\d", text):
            return datetime.date.fromisoformat(text)
    except ValueError:
        pass  # a 31st of June
    raise ExemptionError(f"{line!r}: {text!r} is not a date; expected YYYY-MM-DD")


@dataclass(frozen=True)
class Gates:
    """Coverage thresholds and exemptions of a session.

    Args:
        thresholds: the thresholds of coverage.
        fail_on_nc: fail when no test triggered a requirement, unless `allowed_untriggered` exempts it, also where a
            number of tests was asked for; complete suites always do.
        allowed_untriggered: requirements that need not be triggered.
        known_violations: exemptions for violations; one that has expired fails the session.
        fail_on_pending: fail when a requirement was triggered and undecided at the end of a run.
        fail_on_change: fail when a test behaves differently from the baseline.
    """

    thresholds: tuple[Threshold, ...] = ()
    fail_on_nc: bool = False
    allowed_untriggered: Mapping[str, Exemption] = field(default_factory=dict)
    known_violations: Mapping[str, Exemption] = field(default_factory=dict)
    fail_on_change: bool = False
    fail_on_pending: bool = False
