"""A clock for time-outs that counts only while it is polled: a suspended machine causes none.

A machine sleeps, a job is suspended, a process is stopped (SIGSTOP) and resumes: other processes, and messages to them,
had no usable time meanwhile. Setting a clock has no effect on it either.
"""

from __future__ import annotations

import time

LOOKS_EACH_S = 0.5
"""Interval (s; chosen) at which a waiting process reads the clock."""

_LONGEST_S = 2 * LOOKS_EACH_S
"""A look that comes later (s; chosen: on a busy machine a look is late, too) ends a pause."""


class AwakeClock:
    """Begins with 0."""

    def __init__(self) -> None:
        self._seen_s = time.monotonic()
        self._now_s = 0.0

    def look(self) -> float:
        """The time during which the clock was polled (s of wall time)."""
        now_s = time.monotonic()
        self._now_s += min(now_s - self._seen_s, _LONGEST_S)
        self._seen_s = now_s
        return self._now_s
