"""The `Verdict` of a requirement on a run: triggers, violations, margin, near miss; and its builder.

Each `RequirementMonitor` makes one with a `VerdictBuilder`. Verdicts are plain records, which reports keep.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterable, Mapping
from operator import attrgetter
from typing import Literal

from msgspec import UNSET, UnsetType

from pytest_hricdv._base.record import Count, Names, Number, PlainRecord
from pytest_hricdv.monitor.evaluation_state import NS_PER_S, Nanoseconds, Value, seconds

Outcome = Literal["Passed", "Failed", "NC"]
TriggerOutcome = Literal["passed", "failed", "pending"]


class Violation(PlainRecord, frozen=True):
    """One violation.

    Attributes:
        trigger_s: when the trigger began (s).
        time_s: when it was violated: the first instant of a violation that lasts; the deadline of a missed
            `eventually` (s).
        values: the last values, at `time_s`, of the signals and fields in the requirement that had a value.
        margin: the least signed distance to the bound while the violation lasted; for a missed `eventually`, minus how
            late the response came, or, if it did not come, how long the run continued without it (s); None if the
            violated condition compares nothing.
        outside: violations of this requirement are known under a condition that did not hold at `time_s` (set after
            the run, by `execution.run_monitors`).
        text: what was expected and observed, for people, if the values do not say it.
        margin_s: when the margin was, where that is later than `time_s` (s).
        values_s: value -> when it was (s), of those that were followed to their worst after `time_s`.
    """

    trigger_s: Number
    time_s: Number
    values: Mapping[str, bool | int | float | str]
    margin: Number | None
    outside: bool = False
    text: str = ""
    margin_s: Number | None = None
    values_s: Mapping[str, Number] = {}


class NearMiss(PlainRecord, frozen=True):
    """The time at which the antecedent of a requirement that was never triggered was nearest to being true.

    Attributes:
        time_s: the time at which the fewest of its conjuncts were false; if that was a single conjunct, the time at
            which its distance was least; if there are several such times, the first (s).
        missing: the texts of the conjuncts that were false at that time, or had no value yet; the others were true.
        distance: how far a single false conjunct was from being true, in the unit of its comparison and with its
            hysteresis; None if several were false or it compares nothing.
    """

    time_s: Number
    missing: Names
    distance: Number | None


class Trigger(PlainRecord, frozen=True):
    """One time that the requirement's antecedent asked for its response.

    Attributes:
        begin_s: when (s).
        end_s: when the response was decided: for a state response, when the antecedent became false or the run ended;
            for a pending one, the end of the run (s).
        outcome: what was decided.
    """

    begin_s: float
    end_s: float
    outcome: TriggerOutcome


class RequirementResult(PlainRecord, frozen=True, kw_only=True):
    """The verdict on one requirement in one run, as a report has it.

    `triggers == passes + failures + pending`. Failed: at least one trigger failed. Passed: no trigger failed, and at
    least one was discharged. NC, not checked: no trigger was discharged or failed.

    Attributes:
        verdict: `Passed`, `Failed` or `NC`.
        triggers: how often the antecedent was triggered.
        passes: triggers that were discharged. The end of the run discharges an open safety obligation that is not
            violated: a state response, `until`, or `always[a:b]` if its window has started.
        failures: triggers with a violation; one trigger of a state response may have several.
        untriggered: 1 if the antecedent was never true in this run, else 0; summed over runs, the number of such runs.
        pending: triggers that were undecided at the end of the run.
        violations: the violations, in the order of their times.
        margin: least signed distance to the bound over all triggers, in the unit of the comparison; for `eventually`,
            least time left to the deadline when it was satisfied (s), negative if that was too late, or never: then the
            time from the deadline to the end of the run. None if nothing was compared.
            It does not decide the verdict: at 0.0, `<` fails and `<=` passes.
        margin_time_s: when the margin first occurred (s); UNSET where no run came to an end, as is `near_miss`.
        near_miss: if the antecedent was never true: when it was nearest to it (added by `logged.explain`).
        vacuous_alternatives: if it was triggered: the alternatives `f`, `g` of a response `f | g` by which it never
            held.
        masked_messages: topic -> how many of its messages were not evaluated, because another one came at the same
            instant (added by `logged.explain`).
    """

    verdict: Outcome
    triggers: Count
    passes: Count
    failures: Count
    untriggered: Count
    pending: Count
    violations: tuple[Violation, ...]
    margin: Number | None
    margin_time_s: Number | UnsetType | None = UNSET
    near_miss: NearMiss | UnsetType | None = UNSET
    vacuous_alternatives: Names = ()
    masked_messages: Mapping[str, Count] = {}

    @property
    def outside(self) -> bool:
        """Whether a violation is outside of the condition under which violations of the requirement are known."""
        return any(violation.outside for violation in self.violations)


class Verdict(RequirementResult, frozen=True, kw_only=True):
    """A monitor's verdict: the result, of which requirement, and each trigger.

    Attributes:
        requirement: its id.
        history: the triggers in the order in which they began.
        signature: what was violated, without times and values, if no formula says it: failures with the same one are
            of one kind.
    """

    requirement: str
    margin_time_s: Number | None
    near_miss: NearMiss | None = None
    history: tuple[Trigger, ...] = ()
    signature: Names = ()

    @property
    def result(self) -> RequirementResult:
        """The verdict as a report has it: the fields of a result only."""
        return RequirementResult(**{name: getattr(self, name) for name in RequirementResult.__struct_fields__})


class VerdictBuilder:
    """Collects what happens to one requirement during a run, and gives the verdict.

    There may be a violation an event, and nobody reads them before the end: until then they are columns of numbers.

    Args:
        alternatives: the texts of the response's disjuncts; none if it is not a disjunction.
        most: number of violations and triggers kept, the first ones; the others are only counted.
    """

    def __init__(self, alternatives: Iterable[str] = (), most: float = math.inf) -> None:
        self.unused = dict.fromkeys(alternatives)  # used as an ordered set
        self.most = most
        self.violations = 0
        """How many there are."""
        self.triggers = 0
        self.passes = 0
        self.failures = 0
        self.margin = math.inf
        self._margin_ns: Nanoseconds = 0
        # Violations: trigger and time (ns), margins, values. Triggers: begin and end (ns), outcome.
        self._violated_ns = (array("q"), array("q"))
        self._margins = array("d")
        self._margins_ns = array("q")
        self._values: list[Mapping[str, Value]] = []
        self._values_ns: dict[int, Mapping[str, Nanoseconds]] = {}
        """Violation number -> the times of values that were tracked to their worst."""
        self._decided_ns = (array("q"), array("q"))
        self._outcomes: list[TriggerOutcome] = []

    def add_margin(self, margin: float, now_ns: Nanoseconds) -> None:
        """Keep a margin if it is the least one so far."""
        if margin < self.margin:
            self.margin = margin
            self._margin_ns = now_ns

    def add_violation(
        self,
        trigger_ns: Nanoseconds,
        time_ns: Nanoseconds,
        values: Mapping[str, Value],
        margin: float,
        *,
        margin_ns: Nanoseconds | None = None,
        values_ns: Mapping[str, Nanoseconds] | None = None,
    ) -> None:
        """Record one violation. (`failures` counts triggers; one trigger may have several violations.)

        Args:
            margin_ns: when the margin was; None for the time of the violation.
            values_ns: when those values were that are of another time.
        """
        self.violations += 1
        if self.violations > self.most:
            return
        self._violated_ns[0].append(trigger_ns)  # type: ignore[arg-type]
        self._violated_ns[1].append(time_ns)  # type: ignore[arg-type]
        self._margins.append(margin)
        self._margins_ns.append(time_ns if margin_ns is None else margin_ns)  # type: ignore[arg-type]
        if values_ns:
            self._values_ns[len(self._values)] = values_ns
        self._values.append(values)

    def came_late(self, number: int, late_ns: Nanoseconds, now_ns: Nanoseconds) -> None:
        """Say, once it is known, how late the response is that a violation (from 0) had missed."""
        margin = -late_ns / NS_PER_S
        self.add_margin(margin, now_ns)
        if number >= len(self._margins):
            return
        self._margins[number] = margin
        self._margins_ns[number] = now_ns  # type: ignore[call-overload]

    def decide(self, begin_ns: Nanoseconds, end_ns: Nanoseconds, *, passed: bool) -> None:
        """Count a trigger that was discharged or failed."""
        if passed:
            self.passes += 1
            self._note(begin_ns, end_ns, "passed")
        else:
            self.failures += 1
            self._note(begin_ns, end_ns, "failed")

    def add_pending(self, begin_ns: Nanoseconds, end_ns: Nanoseconds) -> None:
        """Record a trigger that is undecided at the end of the run."""
        self._note(begin_ns, end_ns, "pending")

    def _note(self, begin_ns: Nanoseconds, end_ns: Nanoseconds, outcome: TriggerOutcome) -> None:
        if len(self._outcomes) >= self.most:
            return
        # Times of a run are whole numbers: infinite are only times that do not come.
        self._decided_ns[0].append(begin_ns)  # type: ignore[arg-type]
        self._decided_ns[1].append(end_ns)  # type: ignore[arg-type]
        self._outcomes.append(outcome)

    @property
    def outcome(self) -> Outcome:
        """The verdict by the triggers that are decided."""
        return "Failed" if self.failures else "Passed" if self.passes else "NC"

    def verdict(self, requirement: str, pending: int) -> Verdict:
        """The verdict, with `pending` triggers undecided."""
        margin = _finite_or_none(self.margin)
        return Verdict(
            requirement=requirement,
            verdict=self.outcome,
            triggers=self.triggers,
            passes=self.passes,
            failures=self.failures,
            untriggered=int(self.triggers == 0),
            pending=pending,
            violations=tuple(map(self._violation, range(len(self._values)))),
            margin=margin,
            margin_time_s=None if margin is None else seconds(self._margin_ns),
            history=tuple(sorted(map(_trigger, *self._decided_ns, self._outcomes), key=_by_begin)),
            vacuous_alternatives=tuple(self.unused) if self.triggers else (),
        )

    def _violation(self, number: int) -> Violation:
        time_ns, margin_ns = self._violated_ns[1][number], self._margins_ns[number]
        margin = _finite_or_none(self._margins[number])
        return Violation(
            seconds(self._violated_ns[0][number]),
            seconds(time_ns),
            self._values[number],
            margin,
            margin_s=None if margin is None or margin_ns == time_ns else seconds(margin_ns),
            values_s={name: seconds(at_ns) for name, at_ns in self._values_ns.get(number, {}).items()},
        )


def _trigger(begin_ns: int, end_ns: int, outcome: TriggerOutcome) -> Trigger:
    return Trigger(seconds(begin_ns), seconds(end_ns), outcome)


_by_begin = attrgetter("begin_s")


def _finite_or_none(margin: float) -> float | None:
    # A negated comparison may have the margin -0.0 at its bound; adding 0.0 makes it 0.0.
    return margin + 0.0 if math.isfinite(margin) else None
