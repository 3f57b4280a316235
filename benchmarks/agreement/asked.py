"""What a table-assembly test asks for, read off its commands: one entry for each leg that the person asks for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

REQUEST, READY, BORED = "tell leg", "tell humanReady", "bored"
GOOD = "111"
MOST_TURNS = 4


@dataclass(frozen=True)
class Asked:
    """One request and what the person does for it, up to the next request.

    Args:
        pose: gaze, pressure and location as they are set last, as in "101"; "?" for one that is not set.
        ready: the person says "ready".
        bored: the person walks off.
    """

    pose: str
    ready: bool
    bored: bool

    @property
    def answers(self) -> bool:
        """The robot can come to read its sensors."""
        return self.ready and not self.bored

    @property
    def good(self) -> bool:
        """All three sensors should read that the person is ready."""
        return self.answers and self.pose == GOOD


def asked(lines: Sequence[str]) -> tuple[Asked, ...]:
    """The requests of a test, in order."""
    starts = [place for place, line in enumerate(lines) if line == REQUEST]
    return tuple(_asked(lines[start:end]) for start, end in pairwise([*starts, len(lines)]))


def _asked(lines: Sequence[str]) -> Asked:
    pose = {"gaze": "?", "pressure": "?", "location": "?"}
    for line in lines:
        if line.startswith("set_param"):
            _, name, _, value = line.split()
            pose[name] = value
    return Asked("".join(pose.values()), READY in lines, BORED in lines)


def before_first_request_s(lines: Sequence[str]) -> float | None:
    """The least time that passes before a test's first request is heard (s); None where there is none.

    Words take their shortest time; waiting for a signal takes the person's whole patience, as nobody was asked yet.
    """
    time_s = 0.0
    for line in lines:
        time_s += _LEAST_S.get(line, 0.0)
        if line == REQUEST:
            return time_s
    return None


_LEAST_S = {REQUEST: 3.0, READY: 2.0, "receivesignal": 60.0}
"""Case study."""
