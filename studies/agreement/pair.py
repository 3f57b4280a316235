"""A test of the original and its run here: where the results differ, and the cause as far as the records show it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import zip_longest

from studies.original.requests import ALL_READY, MAX_TURNS, LegRequest, first_request_s
from studies.original.runs import OriginalRun

SAME = "agree"
NOT_HEARD = "the original's robot did not hear a request that came late"
NOT_ASKED = "the original had turns that nobody asked for"
LOST = "the original's record lacks a turn that was asked for"
CONTRADICTION = "the original's verdict contradicts its own record of the turns"
MISSED_SIGNAL = "the original's robot missed what the person said"
UNSAID = "the original's robot went on without the person's \"ready\""
UNRECORDED = "the original missed a reading, or a turn: its turns are not recorded"
IMPOSSIBLE = "the original's record has a release that no sensor error explains"
THEIR_SENSORS = "a sensor erred in the original"
OUR_SENSORS = "a sensor erred here"
SILENT = "the sensors were silent here, as drawn"
EARLY = "said while the robot was busy: the original kept it for later, here it does not count"
HAND = "where the hand is while the robot closes its own is drawn anew"
UNEXPLAINED = "unexplained"

LATE_S = 7.0
"""Time of the earliest first request that the original's robot did not hear; see docs/studies/agreement.md."""

READ = ("released", "discarded")
"""How a turn ends in which the sensors were read."""

Fits = Callable[[str, str], bool]


@dataclass(frozen=True)
class OurRun:
    """The results of a test here.

    Args:
        coverage: statements covered (%).
        verdicts: of R1 to R3.
        legs: how each turn ended.
        readings: of each turn, as in "101"; "none" without one.
    """

    id: str
    coverage: float
    verdicts: Mapping[str, str] = field(hash=False)
    legs: tuple[str, ...]
    readings: tuple[str, ...]


@dataclass(frozen=True)
class Pair:
    """The original's run of a test, and ours."""

    original: OriginalRun
    ours: OurRun

    @cached_property
    def requests(self) -> tuple[LegRequest, ...]:
        """The requests that the robot can serve in its four turns."""
        return self.original.requests[:MAX_TURNS]

    @cached_property
    def record_fault(self) -> str:
        """Why the original's record of turns does not fit the test; empty when it fits or is missing."""
        legs = self.original.legs
        if legs is None:
            return ""
        if len(legs) > len(self.requests):
            return NOT_ASKED
        if len(legs) == len(self.requests):
            return self._order_fault(legs)
        late_s = first_request_s(self.original.lines)
        if not legs and late_s is not None and late_s >= LATE_S:
            return NOT_HEARD
        return LOST if self.waits_for_each else ""

    def _order_fault(self, legs: tuple[str, ...]) -> str:
        """A bored person's turn cannot be decided on readings: then the record is not in the test's order."""
        if any(turn.bored and leg in READ for turn, leg in zip(self.requests, legs, strict=True)):
            return NOT_ASKED
        return ""

    @cached_property
    def waits_for_each(self) -> bool:
        """The person waits for the leg after each request, so that no request meets a busy robot."""
        lines = self.original.lines
        return all(lines[n + 1 : n + 2] == ("receivesignal",) for n, line in enumerate(lines) if line == "tell leg")

    def turn_causes(self) -> list[str]:
        """For each turn of either run: SAME, or the cause of the difference. Empty where turns are not recorded."""
        if self.original.legs is None:
            return []
        causes = []
        for index, (then, now) in enumerate(zip_longest(self.original.legs, self.ours.legs)):
            causes.append(SAME if then == now else self.record_fault or self._turn_cause(index, then, now))
        return causes

    def _turn_cause(self, index: int, then: str | None, now: str | None) -> str:
        if now == "sensing-timeout":
            return SILENT
        if not self.waits_for_each or index >= len(self.requests):
            return self._timing_cause(then)
        turn = self.requests[index]
        if then in READ and now in READ:
            return self._reading_cause(turn, self.ours.readings[index], then, now)
        if turn.answered and then == "no-human-ready":
            return MISSED_SIGNAL
        return UNSAID if then in READ and not turn.answered else UNEXPLAINED

    def _reading_cause(self, turn: LegRequest, reading: str, then: str, now: str) -> str:
        """Why two turns differ although the sensors were read in both."""
        wanted = "released" if turn.pose == ALL_READY else "discarded"
        if now != wanted:
            return OUR_SENSORS if reading_error_explains(turn.pose, reading) else UNEXPLAINED
        return THEIR_SENSORS if then == "discarded" or reading_error_explains(turn.pose, ALL_READY) else IMPOSSIBLE

    def _timing_cause(self, then: str | None) -> str:
        said = any(turn.ready for turn in self.requests)
        return UNSAID if then in READ and not said else EARLY

    def verdict_cause(self, requirement: str) -> str:
        """SAME if both runs have the same verdict on a requirement, else the cause of the difference."""
        then, now = self.original.verdicts[requirement], self.ours.verdicts[requirement]
        if then == now:
            return SAME
        if requirement == "R3":
            return HAND if "NC" not in (then, now) else self.record_fault or self._unrecorded(UNEXPLAINED)
        return self._decision_cause(requirement, then, now)

    def _decision_cause(self, requirement: str, then: str, now: str) -> str:
        if then == "NC" and self._contradicts(requirement):
            return CONTRADICTION
        if self.record_fault:
            return self.record_fault
        if now == "NC":
            return self._unchecked_cause(requirement)
        if requirement == "R1" and not any(turn.all_ready for turn in self.requests):
            return self._misreading_cause()
        if self.original.legs is None:
            return UNRECORDED
        differing = [why for why in self.turn_causes() if why != SAME]
        return differing[0] if differing else UNEXPLAINED

    def _contradicts(self, requirement: str) -> bool:
        """R1 not checked though a leg was released; R2 not checked though one was discarded upon "ready"."""
        legs = self.original.legs or ()
        if requirement == "R1":
            return "released" in legs
        return "discarded" in legs and any(turn.answered for turn in self.requests)

    def _unchecked_cause(self, requirement: str) -> str:
        if "sensing-timeout" in self.ours.legs:
            return SILENT
        asked_readings = zip(self.requests, self.ours.readings, strict=False)
        if requirement == "R1" and any(
            turn.all_ready and reading not in (ALL_READY, "none") for turn, reading in asked_readings
        ):
            return OUR_SENSORS
        if not self.waits_for_each:
            return self._timing_cause("discarded")
        return UNEXPLAINED

    def _misreading_cause(self) -> str:
        """Why a run here read all sensors as ready although the test does not ask for it."""
        turns = zip(self.requests, self.ours.readings, strict=False)
        erred = any(reading == ALL_READY and reading_error_explains(turn.pose, reading) for turn, reading in turns)
        return OUR_SENSORS if erred else UNEXPLAINED

    def _unrecorded(self, otherwise: str) -> str:
        return UNRECORDED if self.original.legs is None else otherwise


def reading_error_explains(pose: str, reading: str) -> bool:
    """Whether sensor errors explain a reading: gaze and location are missed, pressure is read though nobody pulls."""
    allowed = (("1", "0"), ("0", "1"), ("1", "0"))
    pairs = zip(pose, reading, allowed, strict=True)
    return pose != reading and all(was in (read, "?") or (was, read) == error for was, read, error in pairs)


def readings_by_turn(
    legs: Sequence[str], decisions: Iterable[Sequence[str]], requests: Sequence[LegRequest]
) -> tuple[str, ...]:
    """The reading of each turn.

    A report lists the readings of a run, but not in the order of its turns. Among the turns that ended alike, readings
    that equal the pose are assigned first, then those that a sensor error explains, then the rest: so a reading stays
    unexplained only if no order explains it.

    Args:
        legs: how each turn ended.
        decisions: reading and outcome of each turn, in any order.
        requests: what the person did for each turn.

    Raises:
        ValueError: the decisions are not those of the legs.
    """
    left = [(reading, outcome) for reading, outcome in decisions]
    if sorted(outcome for _, outcome in left) != sorted(legs):
        raise ValueError(f"turns that ended {', '.join(legs)} have the decisions {left}")
    poses = [*(turn.pose for turn in requests), *[""] * len(legs)][: len(legs)]
    assigned: dict[int, str] = {}
    rounds: tuple[Fits, ...] = (lambda pose, reading: pose == reading, _explained, lambda pose, reading: True)
    for fits in rounds:
        for index, (pose, leg) in enumerate(zip(poses, legs, strict=True)):
            if index in assigned:
                continue
            fitting = [decision for decision in left if decision[1] == leg and fits(pose, decision[0])]
            if fitting:
                left.remove(fitting[0])
                assigned[index] = fitting[0][0]
    return tuple(assigned[index] for index in range(len(legs)))


def _explained(pose: str, reading: str) -> bool:
    return len(pose) == len(reading) == 3 and reading_error_explains(pose, reading)
