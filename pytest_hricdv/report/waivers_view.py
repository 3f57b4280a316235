"""The view of waivers: what is waived, why, until when, and whether this report still needs it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from pytest_hricdv.report import totals
from pytest_hricdv.report.formatting import Style, by_requirement
from pytest_hricdv.results.model import Report

_OWNED = re.compile(r"(?P<reason>.*\S)\s*\[(?P<owner>[^\[\]]+)\]", re.DOTALL)

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
        subject: requirement, with condition or suites; or file and line.
        reason: for people.
        owner: who answers for it: what stands in brackets at the end of the reason; empty if nobody is named.
        until: the last day; empty for ever.
        state: whether it is still needed, as far as this report tells.
    """

    kind: Literal["known violation", "may be NC", "unreachable line"]
    subject: str
    reason: str
    owner: str
    until: str
    state: WaiverState

    @property
    def style(self) -> Style:
        """How the state is shown."""
        return STYLES[self.state]


def waivers(report: Report) -> tuple[Waiver, ...]:
    """All waivers: known violations, allowed NC, lines declared unreachable."""
    return (*_xfails(report), *_nc_exemptions(report), *_lines(report))


def split_owner(reason: str) -> tuple[str, str]:
    """Reason and owner of `no crush prevention [safety team]`."""
    match = _OWNED.fullmatch(reason)
    return (match["reason"], match["owner"]) if match else (reason, "")


def _xfails(report: Report) -> Iterator[Waiver]:
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


def _lines(report: Report) -> Iterator[Waiver]:
    """Lines; one that ran although it is waived is an error of the session, so that all of them are needed."""
    state: WaiverState = "needed" if report.code_under_test.measured else "not seen in this part"
    for waiver in totals.waivers(report):
        yield Waiver("unreachable line", f"{waiver.file}:{waiver.line}", *split_owner(waiver.reason), "", state)
