"""What the monitors say about a run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

from pytest_hricdv.monitor.view import Nanoseconds, seconds

Outcome = Literal["Passed", "Failed", "NC"]


@dataclass(frozen=True)
class Violation:
    """One violation.

    Attributes:
        trigger_s: when the attempt began (s).
        time_s: when it was violated: the first instant of a violation that lasts; the deadline of a missed
            `eventually` (s).
        values: the last values, at `time_s`, of the signals and fields in the requirement that had one.
        margin: the worst signed distance to the bound while the violation lasted; seconds before the deadline, so 0.0,
            for a missed `eventually`; None if the violated condition compares nothing.
    """

    trigger_s: float
    time_s: float
    values: Mapping[str, float | bool]
    margin: float | None


@dataclass(frozen=True)
class NearestMiss:
    """When the antecedent of a requirement that was never triggered came nearest to holding.

    Attributes:
        time_s: the first time at which the fewest of its conjuncts failed, and the one that failed alone by the least
            distance (s).
        missing: the texts of the conjuncts that failed then, or had no value yet; the others held.
        distance: how far the one that failed alone was from holding, in the unit of its comparison and with its
            hysteresis; None if several failed or it compares nothing.
    """

    time_s: float
    missing: tuple[str, ...]
    distance: float | None


@dataclass(frozen=True)
class Attempt:
    """One attempt: the requirement's antecedent triggered, and its response was owed.

    Attributes:
        begin_s: when it triggered (s).
        end_s: when it was decided: for a state response when the antecedent ceased to hold; else, and for a pending
            one, the end of the run (s).
        outcome: how.
    """

    begin_s: float
    end_s: float
    outcome: Literal["passed", "failed", "pending"]


@dataclass(frozen=True)
class Verdict:
    """One requirement's verdict on a run.

    `attempts == passes + failures + pending`. Failed: some attempt failed. Passed: none did, and one at least was
    discharged. NC, not checked: no attempt was discharged or failed.

    Attributes:
        requirement: its id.
        verdict: `Passed`, `Failed` or `NC`.
        attempts: how often the antecedent triggered.
        passes: attempts that were discharged. A safety obligation (a state response, `until`, or `always[a:b]` whose
            window has begun) that the end of the run finds open and not violated is discharged.
        failures: attempts with a violation; one attempt of a state response may have several.
        vacuous: 1 if the antecedent never held in this run, else 0: summed over runs, the number of vacuous runs. (Not
            instants: their number is a matter of sampling.)
        pending: attempts that the end of the run left undecided.
        violations: in the order of their times.
        margin: least signed distance to the bound over all attempts, in the unit of the comparison; for `eventually`,
            least time left to the deadline when it was satisfied (s), 0.0 if missed. None if nothing was compared.
            It is a figure beside the verdict: at 0.0 the comparison's own `<` or `<=` decides.
        margin_time_s: when the margin occurred first (s).
        nearest_miss: if the antecedent never held: how near it came (see `miss.explained`, which adds this).
        history: the attempts by the time they began; of a monitor that watched the run, not of a log judged later, so
            no part of what makes verdicts equal.
    """

    requirement: str
    verdict: Outcome
    attempts: int
    passes: int
    failures: int
    vacuous: int
    pending: int
    violations: tuple[Violation, ...]
    margin: float | None
    margin_time_s: float | None
    nearest_miss: NearestMiss | None = None
    history: tuple[Attempt, ...] = field(default=(), compare=False)

    def to_json(self) -> dict[str, Any]:
        """The same as plain data for JSON: dicts, lists, numbers, strings."""
        plain = asdict(self)
        plain["violations"] = list(plain["violations"])
        plain["history"] = list(plain["history"])
        if self.nearest_miss is not None:
            plain["nearest_miss"]["missing"] = list(self.nearest_miss.missing)
        return plain


class Tally:
    """Counts the attempts of one requirement during a run."""

    def __init__(self) -> None:
        self.attempts = 0
        self.passes = 0
        self.failures = 0
        self.violations: list[Violation] = []
        self.history: list[Attempt] = []
        self.margin = math.inf
        self._margin_ns: Nanoseconds = 0

    def observe(self, margin: float, now_ns: Nanoseconds) -> None:
        """Take a margin into account."""
        if margin < self.margin:
            self.margin = margin
            self._margin_ns = now_ns

    def violate(
        self, trigger_ns: Nanoseconds, time_ns: Nanoseconds, values: Mapping[str, float | bool], margin: float
    ) -> None:
        """Record one violation; that its attempt failed is counted by `failures`."""
        self.violations.append(Violation(seconds(trigger_ns), seconds(time_ns), values, _finite_or_none(margin)))

    def decide(self, begin_ns: Nanoseconds, end_ns: Nanoseconds, *, passed: bool) -> None:
        """Count an attempt that is over."""
        if passed:
            self.passes += 1
        else:
            self.failures += 1
        self.history.append(Attempt(seconds(begin_ns), seconds(end_ns), "passed" if passed else "failed"))

    def leave(self, begin_ns: Nanoseconds, end_ns: Nanoseconds) -> None:
        """Note an attempt that the end of the run left undecided."""
        self.history.append(Attempt(seconds(begin_ns), seconds(end_ns), "pending"))

    def verdict(self, requirement: str, pending: int) -> Verdict:
        """The verdict, with `pending` attempts still undecided."""
        outcome: Outcome = "Failed" if self.failures else "Passed" if self.passes else "NC"
        margin = _finite_or_none(self.margin)
        return Verdict(
            requirement=requirement,
            verdict=outcome,
            attempts=self.attempts,
            passes=self.passes,
            failures=self.failures,
            vacuous=int(self.attempts == 0),
            pending=pending,
            violations=tuple(self.violations),
            margin=margin,
            margin_time_s=None if margin is None else seconds(self._margin_ns),
            history=tuple(sorted(self.history, key=lambda attempt: attempt.begin_s)),
        )


def _finite_or_none(margin: float) -> float | None:
    # Adding 0.0 makes -0.0, as which a negated comparison may come out at its bound, a plain zero.
    return margin + 0.0 if math.isfinite(margin) else None
