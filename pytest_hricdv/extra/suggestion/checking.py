"""Stored runs, judged by candidates: with the monitors that judge requirements."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from pytest_hricdv.extra.suggestion.mining import Parsed
from pytest_hricdv.monitor import Log, MonitorError, Verdict, evaluate


@dataclass
class Tally:
    """What runs say of a candidate.

    Attributes:
        triggers: how often it asked for something.
        decisive: in how many runs it was passed.
        failed: in how many runs it was violated.
        least: its least margin, in its unit; None where nothing was compared.
        nearest: the test whose margin that was.
    """

    triggers: int = 0
    decisive: int = 0
    failed: int = 0
    least: float | None = None
    nearest: str = ""

    def add(self, verdict: Verdict, test: str) -> None:
        """Count a run."""
        self.triggers += verdict.triggers
        self.decisive += verdict.verdict == "Passed"
        self.failed += verdict.verdict == "Failed"
        if verdict.margin is not None and (self.least is None or verdict.margin < self.least):
            self.least, self.nearest = verdict.margin, test


@dataclass
class Judging:
    """Judges logs by candidates; one that cannot be judged by, such as one that reads what is not there, is dropped."""

    candidates: Sequence[Parsed]
    dropped: set[str] = field(default_factory=set)

    def verdicts(self, log: Log, candidates: Iterable[Parsed] | None = None) -> dict[str, Verdict]:
        """Formula -> verdict on a run."""
        wanted = [
            parsed.requirement
            for parsed in (self.candidates if candidates is None else candidates)
            if parsed.candidate.formula not in self.dropped
        ]
        try:
            return {verdict.requirement: verdict for verdict in evaluate(wanted, log)}
        except MonitorError:
            verdicts = {}
            for requirement in wanted:
                try:
                    [verdicts[requirement.id]] = evaluate([requirement], log)
                except MonitorError:
                    self.dropped.add(requirement.id)
            return verdicts

    def tallies(self, logs: Iterable[tuple[str, Log]]) -> dict[str, Tally]:
        """Formula -> what these runs (each with the id of its test) say of it; without those that were dropped."""
        made: dict[str, Tally] = {parsed.candidate.formula: Tally() for parsed in self.candidates}
        for test, log in logs:
            for formula, verdict in self.verdicts(log).items():
                made[formula].add(verdict, test)
        return {formula: tally for formula, tally in made.items() if formula not in self.dropped}
