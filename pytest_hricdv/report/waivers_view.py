"""`list_waivers`: what a report waives, why, until when, and whether it is still needed, for `html` and the `sheet`."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from pytest_hricdv.report import totals
from pytest_hricdv.report.formatting import Style, by_requirement
from pytest_hricdv.results.model import Report

_REASON_WITH_OWNER = re.compile(r"(?P<reason>.*\S)\s*\[(?P<owner>[^\[\]]+)\]", re.DOTALL)

WaiverState = Literal["needed", "not needed here", "not seen in this part", "ignored: strict", "expired"]

STYLES: dict[WaiverState, Style] = {
    "needed": "plain",
    "not needed here": "warn",
    "not seen in this part": "dim",
    "ignored: strict": "dim",
    "expired": "bad",
}


@dataclass(frozen=True)
class Waiver:
    """One waiver.

    Args:
        kind: "known violation", "may be NC" or "unreachable line".
        subject: the requirement, with its condition or suites; or file and line.
        reason: the declared reason, without the owner.
        owner: who is responsible: the text in brackets at the end of the reason; empty without one.
        until: the last day; empty if it does not expire.
        state: whether it is still needed, as far as this report shows.
    """

    kind: Literal["known violation", "may be NC", "unreachable line"]
    subject: str
    reason: str
    owner: str
    until: str
    state: WaiverState

    @property
    def style(self) -> Style:
        """The style of the state."""
        return STYLES[self.state]


def list_waivers(report: Report) -> tuple[Waiver, ...]:
    """All waivers: known violations, allowed NC, unreachable lines."""
    return (*_violation_waivers(report), *_nc_exemptions(report), *_unreachable_lines(report))


def split_owner(reason: str) -> tuple[str, str]:
    """Split `no crush prevention [safety team]` into reason and owner."""
    match = _REASON_WITH_OWNER.fullmatch(reason)
    return (match["reason"], match["owner"]) if match else (reason, "")


def _violation_waivers(report: Report) -> Iterator[Waiver]:
    whole = bool(report.suites) and all(totals.is_whole(report, suite) for suite in report.suites)
    for name in sorted(report.known_violations.keys() | report.known_until.keys(), key=by_requirement):
        condition = report.known_when.get(name, "")
        failed = any(suite.requirements[name].failed for suite in report.suites if name in suite.requirements)
        state: WaiverState = "needed" if failed else "not needed here" if whole else "not seen in this part"
        if name not in report.known_violations:
            state = "expired"
        elif report.strict:
            state = "ignored: strict"
        subject = f"{name} when {condition}" if condition else name
        reason = report.known_violations.get(name, "")
        yield Waiver("known violation", subject, *split_owner(reason), report.known_until.get(name, ""), state)


def _nc_exemptions(report: Report) -> Iterator[Waiver]:
    for name in sorted(report.allowed_untriggered, key=by_requirement):
        exemption = report.allowed_untriggered[name]
        suites = [suite for suite in report.suites if not exemption.suites or suite.name in exemption.suites]
        tallies = [suite.requirements[name] for suite in suites if name in suite.requirements]
        checked = bool(tallies) and all(tally.passed or tally.failed for tally in tallies)
        state: WaiverState = "not needed here" if checked else "needed" if tallies else "not seen in this part"
        subject = f"{name} in {', '.join(exemption.suites)}" if exemption.suites else name
        yield Waiver("may be NC", subject, *split_owner(exemption.reason), exemption.until, state)


def _unreachable_lines(report: Report) -> Iterator[Waiver]:
    """Unreachable lines. All are needed, since a session reports an error for a waived line that is executed."""
    state: WaiverState = "needed" if report.code_under_test.measured else "not seen in this part"
    for waiver in totals.waivers(report):
        yield Waiver("unreachable line", f"{waiver.file}:{waiver.line}", *split_owner(waiver.reason), "", state)
