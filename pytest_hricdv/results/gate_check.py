"""Checks a report against gates and a baseline, and lists what fails the session and what improved.

`GateCheck`, campaigns and `hricdv report gate` call `check_gates`. `compare` compares violations, errors, triggers and
coverage with the baseline.
"""

from __future__ import annotations

import datetime
from collections.abc import Iterable, Iterator, Mapping, Sequence

from pytest_hricdv._base.message import list_names
from pytest_hricdv.coverage.gaps import near_miss
from pytest_hricdv.registry import offers
from pytest_hricdv.results.baseline import Baseline, SuiteBaseline, baseline_of
from pytest_hricdv.results.behaviour import BehaviourChanges, Difference
from pytest_hricdv.results.behaviour_diff import headline
from pytest_hricdv.results.codec import ReportError
from pytest_hricdv.results.derivation import percentages
from pytest_hricdv.results.gates import Exemption, Gates, Threshold, threshold_kinds
from pytest_hricdv.results.model import GatePolicy, GateResult, Report
from pytest_hricdv.results.section import shares

NEW_CAUSE = "new cause"
"""`Difference.what` for a cause that the baseline lacks; the item is the cause's id."""

_PERCENT = ("statements", "branches")


def compare(report: Report, baseline: Baseline, *, whole: bool) -> tuple[Difference, ...]:
    """Compare a report with a baseline; returns the differences for the worse first.

    A violation is new if the test did not violate the requirement in the baseline, whether it is a known violation or
    not. Code is compared by percentage, since lines move; plans, bins and triggers are compared by name.

    Args:
        whole: whether all tests of the suites were selected; if not, only failures are compared.
    """
    differences: list[Difference] = []
    for name, now in baseline_of(report).suites.items():
        before = baseline.suites.get(name)
        if before is None:
            text = f"suite {name} is not in the baseline: --hri-update-baseline adds it"
            differences.append(
                Difference(suite=name, what="suite", before="-", now="new", items=(), worse=False, text=text)
            )
        else:
            suite = _SuiteComparison(name, before, now)
            differences += [
                *suite.new_causes(),
                *suite.new_failures(),
                *(suite.other_differences() if whole else ()),
            ]
    return tuple(sorted(differences, key=lambda difference: not difference.worse))


class _SuiteComparison:
    """The differences of one suite."""

    def __init__(self, name: str, before: SuiteBaseline, now: SuiteBaseline) -> None:
        self.name, self.before, self.now = name, before, now

    def new_causes(self) -> Iterator[Difference]:
        """The causes that the baseline lacks."""
        for name, words in (self.now.causes or {}).items():
            if self.before.causes is not None and name not in self.before.causes:
                yield self._difference(NEW_CAUSE, ("-", "new"), f"new cause {name}: {words}", items=(name,), worse=True)

    def _causes_gone(self) -> Iterator[Difference]:
        for name, words in (self.before.causes or {}).items():
            if self.now.causes is not None and name not in self.now.causes:
                text = f"cause {name} is gone: {words}"
                yield self._difference("cause", ("there", "gone"), text, items=(name,), worse=False)

    def new_failures(self) -> Iterator[Difference]:
        for requirement, tests in self.now.violations.items():
            old = self.before.violations.get(requirement, ())
            new = sorted(set(tests) - set(old))
            if new:
                grown = f": grown from {len(old)} to {len(tests)} tests" if len(tests) > len(old) > 0 else ""
                text = f"{requirement} is newly violated by {list_names(new)}{grown}"
                yield self._test_difference(f"{requirement} violated", old, tests, new, text, worse=True)
        new = sorted(set(self.now.broken) - set(self.before.broken))
        if new:
            text = f"newly in error or at fault: {list_names(new)}"
            yield self._test_difference(
                "in error or at fault", self.before.broken, self.now.broken, new, text, worse=True
            )

    def other_differences(self) -> Iterator[Difference]:
        """The differences that only a complete suite shows."""
        yield from self._causes_gone()
        for requirement, tests in self.before.violations.items():
            still = self.now.violations.get(requirement, ())
            fixed = sorted(set(tests) - set(still))
            if fixed:
                text = f"{requirement} is no longer violated by {list_names(fixed)}"
                yield self._test_difference(f"{requirement} violated", tests, still, fixed, text, worse=False)
        yield from self._triggers()
        for kind in _PERCENT:
            yield from self._percent(kind)
        yield from self._coverage_changes()

    def _triggers(self) -> Iterator[Difference]:
        for requirement in {**self.before.triggers, **self.now.triggers}:
            before, now = self.before.triggers.get(requirement, 0), self.now.triggers.get(requirement, 0)
            if bool(before) != bool(now):
                lost = f"{requirement} is no longer triggered; {before} times in the baseline"
                text = f"{requirement} is triggered now, {now} times" if now else lost
                yield self._difference(f"{requirement} triggered", (str(before), str(now)), text, worse=not now)

    def _percent(self, kind: str) -> Iterator[Difference]:
        before, now = self.before.percent.get(kind), self.now.percent.get(kind)
        if before == now:
            return
        shown, then = ("unmeasured" if percent is None else f"{percent:.2f} %" for percent in (now, before))
        worse = now is None or (before is not None and now < before)
        yield self._difference(kind, (then, shown), f"{kind} {shown}; {then} in the baseline", worse=worse)

    def _coverage_changes(self) -> Iterator[Difference]:
        """Plans and bins that were lost, then those that were gained."""
        before, now = _points(self.before), _points(self.now)
        for worse, word, some, others in ((True, "lost", before, now), (False, "gained", now, before)):
            for kind, points in some.items():
                missing = sorted(points - others.get(kind, set()))
                if missing:
                    counts = (str(len(before.get(kind, ()))), str(len(now.get(kind, ()))))
                    text = f"{word} {kind}: {list_names(missing)}"
                    yield self._difference(kind, counts, text, items=tuple(missing), worse=worse)

    def _test_difference(
        self, kind: str, before: Sequence[str], now: Sequence[str], items: list[str], text: str, *, worse: bool
    ) -> Difference:
        counts = (_count_tests(len(before)), _count_tests(len(now)))
        return self._difference(kind, counts, text, items=tuple(items), worse=worse)

    def _difference(
        self, kind: str, values: tuple[str, str], text: str, *, items: tuple[str, ...] = (), worse: bool
    ) -> Difference:
        before, now = values
        text = f"suite {self.name}: {text}"
        return Difference(suite=self.name, what=kind, before=before, now=now, items=items, worse=worse, text=text)


def _count_tests(count: int) -> str:
    return f"{count} test{'s' * (count != 1)}"


def _points(suite: SuiteBaseline) -> dict[str, set[str]]:
    """The covered points by name: plans of each agent, and bins of each cross product."""
    plans = {f"plans of {agent}": set(plans) for agent, plans in suite.plans.items()}
    return plans | {f"bins of {name}": {" x ".join(bin_) for bin_ in bins} for name, bins in suite.bins.items()}


def gates_of(
    report: Report,
    *,
    thresholds: Iterable[Threshold] = (),
    fail_on_nc: bool = False,
    allowed: Iterable[str] = (),
    fail_on_change: bool = False,
    fail_on_pending: bool = False,
) -> Gates:
    """Gates from the policy and the exemptions in a report, and from further arguments.

    Args:
        thresholds: replace those of the policy of the same kinds.
        fail_on_nc: whether NC fails in addition to the policy; likewise `fail_on_change` and `fail_on_pending`.
        allowed: further requirements that need not be triggered.

    Raises:
        ReportError: an exemption has an invalid date.
    """
    allowed_untriggered = {
        name: Exemption(name, exemption.reason, _day(exemption.until), suites=exemption.suites)
        for name, exemption in report.allowed_untriggered.items()
    } | {name: Exemption(name, "named with --allow-nc") for name in allowed}
    policy = report.policy or GatePolicy()
    named = tuple(thresholds)
    kept = (Threshold(kind, percent, named=False) for kind, percent in policy.thresholds.items())
    others = (threshold for threshold in kept if threshold.kind not in {other.kind for other in named})
    return Gates(
        (*named, *others),
        fail_on_nc or policy.fail_on_nc,
        allowed_untriggered,
        _violation_exemptions(report),
        fail_on_change or policy.fail_on_change,
        fail_on_pending or policy.fail_on_pending,
    )


def _violation_exemptions(report: Report) -> dict[str, Exemption]:
    names = {} if report.strict else dict.fromkeys([*report.known_violations, *report.known_until])
    return {
        name: Exemption(
            name,
            report.known_violations.get(name, "no longer known"),
            _day(report.known_until.get(name, "")),
            report.known_when.get(name, ""),
        )
        for name in names
    }


def policy_of(gates: Gates) -> GatePolicy | None:
    """The gates of a session as they are kept in its report; None if there are none."""
    thresholds = {threshold.kind: threshold.percent for threshold in gates.thresholds}
    if not (thresholds or gates.fail_on_nc or gates.fail_on_change or gates.fail_on_pending):
        return None
    return GatePolicy(
        thresholds=thresholds,
        fail_on_nc=gates.fail_on_nc,
        fail_on_change=gates.fail_on_change,
        fail_on_pending=gates.fail_on_pending,
    )


def _day(text: str) -> datetime.date | None:
    try:
        return datetime.date.fromisoformat(text) if text else None
    except ValueError as error:
        raise ReportError(f"an exemption of the report: {error}") from None


def check_gates(
    report: Report, gates: Gates, baseline: Baseline | None, today: datetime.date, *, whole: bool
) -> GateResult:
    """Check a report against gates, and compare it with a baseline if there is one.

    Args:
        today: the day with which expiry dates are compared.
        whole: whether all tests of the suites were selected. If not, only these are checked: thresholds of the command
            line, expired exemptions of violations that occurred, new failures, and changes of behaviour.
    """
    failed = [
        *_expiry_failures(report, gates, today, whole=whole),
        *_threshold_failures(report, gates.thresholds, whole=whole),
    ]
    if whole and (gates.fail_on_nc or has_complete_suites(report)):
        failed += _nc_failures(report, gates.allowed_untriggered, today)
    if gates.fail_on_pending:
        failed += _failures_before_the_end(report)
    if gates.fail_on_change and report.changes is not None:
        failed += _change_failures(report, report.changes)
    improved = list(_exemptions_without_need(report, gates)) if whole else []
    differences = () if baseline is None else compare(report, baseline, whole=whole)
    failed += [difference.text for difference in differences if difference.worse]
    improved += [difference.text for difference in differences if not difference.worse]
    return GateResult(failed=tuple(failed), improved=tuple(improved), differences=differences)


def has_complete_suites(report: Report) -> bool:
    """Whether a report is of complete suites: no replays, no selection, and no `--hri-tests`."""
    tests = {(test.suite, test.id) for test in report.tests}
    limited = any(option.startswith("--hri-tests=") for option in report.rerun_options.options)
    is_complete = len(tests) == sum(suite.size for suite in report.suites) and not report.not_run
    return bool(report.rerun_options.suite) and is_complete and not limited


def _threshold_failures(report: Report, thresholds: tuple[Threshold, ...], *, whole: bool) -> Iterator[str]:
    unmeasured = {share.kind for share in shares() if not share.is_measured(report)}
    for threshold in sorted(thresholds, key=lambda threshold: threshold_kinds().index(threshold.kind)):
        if not (threshold.named or whole):
            continue
        if not threshold.named and threshold.kind in unmeasured:
            continue  # a feature measures its figure only in sessions that ask for it
        for suite, percent in percentages(report, threshold.kind):
            if percent is None:
                yield f"suite {suite}: {threshold.kind} unmeasured, at least {threshold.percent:g} % asked for"
            elif percent < threshold.percent:
                yield f"suite {suite}: {threshold.kind} {percent:.2f} %, at least {threshold.percent:g} % asked for"


def _expiry_failures(report: Report, gates: Gates, today: datetime.date, *, whole: bool) -> Iterator[str]:
    for name, exemption in gates.known_violations.items():
        if exemption.is_expired(today) and (whole or _violations(report, name)):
            yield (
                f"the known violation of {name} ({exemption.text}) was accepted until {exemption.until} and has "
                "expired: fix it, or agree on another date in hri_known_violations"
            )


def _nc_failures(report: Report, exemptions: Mapping[str, Exemption], today: datetime.date) -> Iterator[str]:
    suites = {suite.name for suite in report.suites}
    for name in _nc_requirements(report):
        exemption = exemptions.get(name)
        if exemption is None or (exemption.suites and not suites.issubset(exemption.suites)):
            results = ((test.id, test.requirements[name]) for test in report.tests if name in test.requirements)
            test, missing = near_miss(results)
            near = f"nearest was {test}, which lacked {' & '.join(missing)}" if test else "nor came near"
            yield f"{name} was not checked: no test triggered it; {near}; if it may be so, say why in hri_allow_nc"
        elif exemption.is_expired(today):
            yield f"{name} was not checked, which was accepted until {exemption.until} ({exemption.reason})"


def _failures_before_the_end(report: Report) -> Iterator[str]:
    for name in report.requirements:
        tests = [test for test in report.tests if name in test.requirements and test.requirements[name].pending]
        if tests:
            pending = sum(test.requirements[name].pending for test in tests)
            triggers = sum(test.requirements[name].triggers for test in report.tests if name in test.requirements)
            yield (
                f"{name} was pending at the end: {pending} of {triggers} triggers undecided when their runs ended, for "
                f"instance of {tests[0].id}; if they could still be decided, give run.go a longer limit"
            )


def _change_failures(report: Report, changes: BehaviourChanges) -> Iterator[str]:
    if changes.changed or (report.reported and not changes.compared):
        yield headline(changes)


def _nc_requirements(report: Report) -> list[str]:
    return [
        name for name in report.requirements if not any(suite.requirements[name].triggers for suite in report.suites)
    ]


def _exemptions_without_need(report: Report, gates: Gates) -> Iterator[str]:
    """Exemptions that are no longer needed.

    Suites that were generated to trigger each requirement do not count: other suites may still need the exemption.
    """
    targeted = {target_suite(report) for target_suite in offers("records", "target_suite")}
    untriggered = _nc_requirements(report)
    suites = {suite.name for suite in report.suites if suite.name not in targeted}
    for name, exemption in gates.known_violations.items():
        if not _violations(report, name) and name not in untriggered and exemption.reason:
            yield f"{name} is a known violation, but no test violated it ({exemption.text})"
    for name, exemption in gates.allowed_untriggered.items():
        checked = any(suite.requirements[name].triggers for suite in report.suites if suite.name in suites)
        if checked and suites.issubset(exemption.suites or suites):
            yield f"{name} was checked, so its exemption can go (hri_allow_nc: {exemption.reason})"


def _violations(report: Report, requirement: str) -> int:
    return sum(test.violates(requirement) for test in report.tests)
