"""A test of the original beside our run of it: where they disagree, and why, as far as their records tell."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import zip_longest

from benchmarks.agreement.asked import GOOD, MOST_TURNS, Asked, before_first_request_s
from benchmarks.agreement.original import OriginalRun

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
"""The earliest first request that the original's robot did not hear came so long after the start; see the page."""

READ = ("released", "discarded")


@dataclass(frozen=True)
class OurRun:
    """What came of a test here.

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
    """One test, run then and now."""

    theirs: OriginalRun
    ours: OurRun

    @cached_property
    def requests(self) -> tuple[Asked, ...]:
        """What the robot can be asked for in its four turns."""
        return self.theirs.asked[:MOST_TURNS]

    @cached_property
    def awry(self) -> str:
        """Why the original's turns as a whole are not the test's; empty when they are, or are not recorded."""
        legs = self.theirs.legs
        if legs is None:
            return ""
        if len(legs) > len(self.requests):
            return NOT_ASKED
        if len(legs) == len(self.requests):
            return self._disordered(legs)
        late_s = before_first_request_s(self.theirs.lines)
        if not legs and late_s is not None and late_s >= LATE_S:
            return NOT_HEARD
        return LOST if self.waits_for_each else ""

    def _disordered(self, legs: tuple[str, ...]) -> str:
        """A bored person's turn cannot be decided on readings: then the record is not in the test's order."""
        if any(turn.bored and leg in READ for turn, leg in zip(self.requests, legs, strict=True)):
            return NOT_ASKED
        return ""

    @cached_property
    def waits_for_each(self) -> bool:
        """The person waits for the leg after each request, so that no request meets a busy robot."""
        lines = self.theirs.lines
        return all(lines[n + 1 : n + 2] == ("receivesignal",) for n, line in enumerate(lines) if line == "tell leg")

    def legs(self) -> list[str]:
        """For each turn of either, that they agree, or why they do not; nothing where turns are not recorded."""
        if self.theirs.legs is None:
            return []
        found = []
        for place, (then, now) in enumerate(zip_longest(self.theirs.legs, self.ours.legs)):
            found.append(SAME if then == now else self.awry or self._leg(place, then, now))
        return found

    def _leg(self, place: int, then: str | None, now: str | None) -> str:
        if now == "sensing-timeout":
            return SILENT
        if not self.waits_for_each or place >= len(self.requests):
            return self._mistimed(then)
        turn = self.requests[place]
        if then in READ and now in READ:
            return self._sensed(turn, self.ours.readings[place], then, now)
        if turn.answers and then == "no-human-ready":
            return MISSED_SIGNAL
        return UNSAID if then in READ and not turn.answers else UNEXPLAINED

    def _sensed(self, turn: Asked, reading: str, then: str, now: str) -> str:
        """Why two turns ended differently in which the sensors were read."""
        wanted = "released" if turn.pose == GOOD else "discarded"
        if now != wanted:
            return OUR_SENSORS if errs(turn.pose, reading) else UNEXPLAINED
        return THEIR_SENSORS if then == "discarded" or errs(turn.pose, GOOD) else IMPOSSIBLE

    def _mistimed(self, then: str | None) -> str:
        said = any(turn.ready for turn in self.requests)
        return UNSAID if then in READ and not said else EARLY

    def verdict(self, requirement: str) -> str:
        """That they agree on a requirement, or why they do not."""
        then, now = self.theirs.verdicts[requirement], self.ours.verdicts[requirement]
        if then == now:
            return SAME
        if requirement == "R3":
            return HAND if "NC" not in (then, now) else self.awry or self._unrecorded(UNEXPLAINED)
        return self._decided(requirement, then, now)

    def _decided(self, requirement: str, then: str, now: str) -> str:
        if then == "NC" and self._contradicts(requirement):
            return CONTRADICTION
        if self.awry:
            return self.awry
        if now == "NC":
            return self._not_checked_here(requirement)
        if requirement == "R1" and not any(turn.good for turn in self.requests):
            return self._misread()
        if self.theirs.legs is None:
            return UNRECORDED
        differing = [why for why in self.legs() if why != SAME]
        return differing[0] if differing else UNEXPLAINED

    def _contradicts(self, requirement: str) -> bool:
        """R1 not checked though a leg was released; R2 not checked though one was discarded upon "ready"."""
        legs = self.theirs.legs or ()
        if requirement == "R1":
            return "released" in legs
        return "discarded" in legs and any(turn.answers for turn in self.requests)

    def _not_checked_here(self, requirement: str) -> str:
        if "sensing-timeout" in self.ours.legs:
            return SILENT
        asked_readings = zip(self.requests, self.ours.readings, strict=False)
        if requirement == "R1" and any(turn.good and reading not in (GOOD, "none") for turn, reading in asked_readings):
            return OUR_SENSORS
        if not self.waits_for_each:
            return self._mistimed("discarded")
        return UNEXPLAINED

    def _misread(self) -> str:
        """Why a run here has a reading that is all ready though that was not asked for."""
        turns = zip(self.requests, self.ours.readings, strict=False)
        erred = any(reading == GOOD and errs(turn.pose, reading) for turn, reading in turns)
        return OUR_SENSORS if erred else UNEXPLAINED

    def _unrecorded(self, otherwise: str) -> str:
        return UNRECORDED if self.theirs.legs is None else otherwise


def errs(pose: str, reading: str) -> bool:
    """Whether sensor errors explain a reading: gaze and location are missed, pressure is felt though nobody pulls."""
    allowed = (("1", "0"), ("0", "1"), ("1", "0"))
    pairs = zip(pose, reading, allowed, strict=True)
    return pose != reading and all(was in (read, "?") or (was, read) == error for was, read, error in pairs)
