"""The legs that a table-assembly test asks for, read from its commands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

REQUEST, READY, BORED = "tell leg", "tell humanReady", "bored"
ALL_READY = "111"
MAX_TURNS = 4
MIN_DURATION_S = {REQUEST: 3.0, READY: 2.0, "receivesignal": 60.0}
"""Words take their shortest time; waiting for a signal lasts until the person loses patience."""


@dataclass(frozen=True)
class LegRequest:
    """One request and what the person does until the next request.

    Args:
        pose: gaze, pressure and location as they are set last, as in "101"; "?" for one that is not set.
        ready: the person says "ready".
        bored: the person walks off.
    """

    pose: str
    ready: bool
    bored: bool

    @property
    def answered(self) -> bool:
        """The person answers, so that the robot can read its sensors."""
        return self.ready and not self.bored

    @property
    def all_ready(self) -> bool:
        """All three sensors should read that the person is ready."""
        return self.answered and self.pose == ALL_READY


def leg_requests(lines: Sequence[str]) -> tuple[LegRequest, ...]:
    """The requests of a test, in order."""
    starts = [index for index, line in enumerate(lines) if line == REQUEST]
    return tuple(_request(lines[start:end]) for start, end in pairwise([*starts, len(lines)]))


def _request(lines: Sequence[str]) -> LegRequest:
    pose = {"gaze": "?", "pressure": "?", "location": "?"}
    for line in lines:
        if line.startswith("set_param"):
            _, name, _, value = line.split()
            pose[name] = value
    return LegRequest("".join(pose.values()), READY in lines, BORED in lines)


def first_request_s(lines: Sequence[str]) -> float | None:
    """The earliest time (s) at which a test's first request is complete; None for a test without requests."""
    time_s = 0.0
    for line in lines:
        time_s += MIN_DURATION_S.get(line, 0.0)
        if line == REQUEST:
            return time_s
    return None
