"""Compares a run with its baseline: violations, errors, triggers and coverage."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pytest_hricdv.results.baseline import Baseline, SuiteBaseline, baseline_of
from pytest_hricdv.results.behaviour import Difference
from pytest_hricdv.results.model import Report

NEW_CAUSE = "new cause"
"""The subject of a difference between causes; its item is the id."""

_PERCENT = ("statements", "branches")


def compare(report: Report, baseline: Baseline, *, whole: bool) -> tuple[Difference, ...]:
    """Compare a report with a baseline: differences for the worse first.

    A violation is new where the test did not violate that requirement before, known or not. Code is compared by
    percentage, since lines move; plans, bins and triggers by name. Of a part of the tests only failures are compared.

    Args:
        whole: all tests of the suites were selected.
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
            differences += [*suite.new_causes(), *suite.new_failures(), *(suite.others() if whole else ())]
    return tuple(sorted(differences, key=lambda difference: not difference.worse))


class _SuiteComparison:
    """A suite's differences."""

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
                text = f"{requirement} is newly violated by {_list_names(new)}{grown}"
                yield self._tests(f"{requirement} violated", old, tests, new, text, worse=True)
        new = sorted(set(self.now.broken) - set(self.before.broken))
        if new:
            text = f"newly in error or at fault: {_list_names(new)}"
            yield self._tests("in error or at fault", self.before.broken, self.now.broken, new, text, worse=True)

    def others(self) -> Iterator[Difference]:
        """The differences that need whole suites."""
        yield from self._causes_gone()
        for requirement, tests in self.before.violations.items():
            still = self.now.violations.get(requirement, ())
            fixed = sorted(set(tests) - set(still))
            if fixed:
                text = f"{requirement} is no longer violated by {_list_names(fixed)}"
                yield self._tests(f"{requirement} violated", tests, still, fixed, text, worse=False)
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
        """Plans and bins that were lost or gained."""
        before, now = _points(self.before), _points(self.now)
        for worse, word, some, others in ((True, "lost", before, now), (False, "gained", now, before)):
            for kind, points in some.items():
                missing = sorted(points - others.get(kind, set()))
                if missing:
                    counts = (str(len(before.get(kind, ()))), str(len(now.get(kind, ()))))
                    text = f"{word} {kind}: {_list_names(missing)}"
                    yield self._difference(kind, counts, text, items=tuple(missing), worse=worse)

    def _tests(
        self, kind: str, before: Sequence[str], now: Sequence[str], items: list[str], text: str, *, worse: bool
    ) -> Difference:
        counts = (_tests(len(before)), _tests(len(now)))
        return self._difference(kind, counts, text, items=tuple(items), worse=worse)

    def _difference(
        self, kind: str, values: tuple[str, str], text: str, *, items: tuple[str, ...] = (), worse: bool
    ) -> Difference:
        before, now = values
        text = f"suite {self.name}: {text}"
        return Difference(suite=self.name, what=kind, before=before, now=now, items=items, worse=worse, text=text)


def _tests(count: int) -> str:
    return f"{count} test{'s' * (count != 1)}"


def _points(suite: SuiteBaseline) -> dict[str, set[str]]:
    """The covered points by name: plans of each agent, and bins of each cross product."""
    plans = {f"plans of {agent}": set(plans) for agent, plans in suite.plans.items()}
    return plans | {f"bins of {name}": {" x ".join(bin_) for bin_ in bins} for name, bins in suite.bins.items()}


def _list_names(names: list[str], most: int = 3) -> str:
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more
