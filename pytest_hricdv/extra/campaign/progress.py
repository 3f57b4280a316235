"""The progress of a campaign: one line that is rewritten on a terminal, and ten lines elsewhere."""

from __future__ import annotations

import shutil
import sys
import time
from collections.abc import Mapping
from typing import TextIO

from pytest_hricdv._base.message import visible
from pytest_hricdv.execution.outcome import FAILING
from pytest_hricdv.extra.campaign.row import LOST
from pytest_hricdv.extra.campaign.store import Store
from pytest_hricdv.report.formatting import fit_list
from pytest_hricdv.session.progress import time_left

STEPS = 10  # a log of CI has ten lines, however long the campaign is
EVERY_S = 1.0  # counting a million rows takes 0.13 s, and this is called with each answer


def outcomes(counts: Mapping[str, int]) -> str:
    """`12 failed, 1 lost`."""
    failed, lost = sum(counts.get(name, 0) for name in FAILING), counts.get(LOST, 0)
    return f"{failed:,} failed, {lost:,} lost"


class CampaignProgress:
    """Tells how far a campaign is.

    Args:
        store: of the campaign.
        expected: runs of the campaign.
        stream: that is written to.
    """

    def __init__(self, store: Store, expected: int, stream: TextIO = sys.stdout) -> None:
        self._store = store
        self._expected = expected
        self._stream = stream
        self._began_s = self._last_s = time.monotonic()
        self._before = store.counts()
        self._step = self._step_of(self._before.runs)
        self._rewrites = stream.isatty()
        self._has_line = False

    def show(self) -> None:
        """Tell it, where there is something new to tell."""
        now_s = time.monotonic()
        if now_s - self._last_s < EVERY_S:
            return
        self._last_s = now_s
        counts = self._store.counts()
        step = self._step_of(counts.runs)
        if self._rewrites:
            line = fit_list(self._texts(now_s), shutil.get_terminal_size().columns - 1)  # one that wraps leaves a rest
            self._stream.write(f"\r\x1b[2K{line}")
            self._has_line = True
        elif step > self._step:
            self._stream.write(f"{self._texts(now_s)[0]}\n")
        self._step = step
        self._stream.flush()

    def _texts(self, now_s: float) -> list[str]:
        """The fullest first: then without the speed, the time left, and the outcomes."""
        counts, took_s = self._store.counts(), max(1e-9, now_s - self._began_s)
        done = counts.runs - self._before.runs
        speed = (counts.sim_s - self._before.sim_s) / took_s
        left = (self._expected - counts.runs) * took_s / done if done else None
        start = [f"{counts.runs:,} of {self._expected:,} runs", outcomes(counts.outcomes)]
        end = [time_left(left)] if left is not None and counts.runs < self._expected else []
        fullest = [*start, f"{speed:,.0f} simulated s a second", *end]
        return [", ".join(parts) for parts in (fullest, [*start, *end], start, start[:1])]

    def say(self, text: str) -> None:
        """Tell something else, on a line of its own."""
        if self._has_line:
            self._stream.write("\r\x1b[2K")
            self._has_line = False
        self._stream.write(f"{visible(text)}\n")
        self._stream.flush()

    def _step_of(self, stored: int) -> int:
        return stored * STEPS // max(1, self._expected)
