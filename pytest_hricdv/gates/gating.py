"""Gates: what a report has to reach for the run to pass."""

from __future__ import annotations

import datetime
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from pytest_hricdv.closure.closing import Entry, reached
from pytest_hricdv.gates.allowance import Allowance
from pytest_hricdv.gates.baseline import compare
from pytest_hricdv.gates.bound import KINDS, Bound
from pytest_hricdv.gates.gates import Gates


@dataclass(frozen=True)
class Judgement:
    """What fails a run, and what is better than it was, a sentence each."""

    failed: tuple[str, ...] = ()
    improved: tuple[str, ...] = ()


def judge(report: Entry, gates: Gates, today: datetime.date, *, whole: bool) -> Judgement:
    """Hold a report against gates.

    Args:
        today: the day on which allowances are looked at.
        whole: all tests of the suites were selected. Of a part only what was asked for on the command line is held
            against, violations that are no longer allowed, and new failures.
    """
    failed = [*_expired(report, gates, today, whole=whole), *_under(report, gates.bounds, whole=whole)]
    if whole and gates.fail_on_nc:
        failed += _unchecked(report, gates.may_be_nc, today)
    improved = list(_needless(report, gates)) if whole else []
    if gates.baseline is not None:
        comparison = compare(report, gates.baseline, whole=whole)
        failed += comparison.worse
        improved += comparison.better
    return Judgement(tuple(failed), tuple(improved))


def _under(report: Entry, bounds: tuple[Bound, ...], *, whole: bool) -> Iterator[str]:
    for bound in sorted(bounds, key=lambda bound: KINDS.index(bound.kind)):
        if not (bound.named or whole):
            continue
        for suite, percent in reached(report, bound.kind):
            if percent is None:
                yield f"suite {suite}: {bound.kind} unmeasured, at least {bound.percent:g} % asked for"
            elif percent < bound.percent:
                yield f"suite {suite}: {bound.kind} {percent:.2f} %, at least {bound.percent:g} % asked for"


def _expired(report: Entry, gates: Gates, today: datetime.date, *, whole: bool) -> Iterator[str]:
    for name, known in gates.known.items():
        if known.expired(today) and (whole or _violations(report, name)):
            yield (
                f"the known violation of {name} ({known.reason}) was accepted until {known.until}, which is over: "
                "mend it, or agree on another day in hri_known_violations"
            )


def _unchecked(report: Entry, allowed: Mapping[str, Allowance], today: datetime.date) -> Iterator[str]:
    for name in _untriggered(report):
        allowance = allowed.get(name)
        if allowance is None:
            yield f"{name} was not checked: no test triggered it; {_nearest(report, name)}"
        elif allowance.expired(today):
            yield f"{name} was not checked, which was accepted until {allowance.until} ({allowance.reason})"


def _untriggered(report: Entry) -> list[str]:
    return [
        name
        for name in report["requirements"]
        if not any(suite["requirements"][name]["triggers"] for suite in report["suites"])
    ]


def _nearest(report: Entry, requirement: str) -> str:
    """How near a test came to triggering it: the one that lacked the fewest conditions."""
    misses = [
        (len(miss["missing"]), test["id"], miss["missing"])
        for test in report["tests"]
        if (miss := test["requirements"][requirement].get("nearest_miss"))
    ]
    if not misses:
        return "nor came near"
    _, test, missing = min(misses)
    return f"nearest was {test}, which lacked {' & '.join(missing)}"


def _needless(report: Entry, gates: Gates) -> Iterator[str]:
    """What was allowed for and is no longer needed."""
    untriggered = _untriggered(report)
    for name, known in gates.known.items():
        if not _violations(report, name) and name not in untriggered and known.reason:
            yield f"{name} is a known violation ({known.reason}), but no test violated it"
    for name, allowed in gates.may_be_nc.items():
        if gates.fail_on_nc and name not in untriggered:
            yield f"{name} need not be checked ({allowed.reason}), but was"


def _violations(report: Entry, requirement: str) -> int:
    return sum(test["requirements"][requirement]["verdict"] == "Failed" for test in report["tests"])
