"""Progress of a campaign, and the time left."""

from __future__ import annotations

import time

from benchmarks.campaign.shard import Shard


class Progress:
    """Prints the progress after each seed.

    Args:
        seeds: of the whole campaign.
        left: of them, not done when this process began.
        tests: runs of each seed.
    """

    def __init__(self, seeds: int, left: int, tests: int) -> None:
        self._seeds, self._left, self._of_all = seeds, left, left
        self._began_s = time.monotonic()
        total = f"{seeds} seeds of {tests} tests, {seeds * tests} runs"
        print(f"campaign: {total}; {seeds - left} seeds are done", flush=True)

    def done(self, shard: Shard) -> None:
        """A seed was run."""
        self._left -= 1
        mean_s = (time.monotonic() - self._began_s) / (self._of_all - self._left)
        print(
            f"seed {shard.seed}: {len(shard.runs)} runs in {shard.wall_s:.0f} s ({shard.cpu_s:.0f} s of processor); "
            f"{self._seeds - self._left} of {self._seeds} done, about {duration(self._left * mean_s)} left",
            flush=True,
        )


def duration(seconds: float) -> str:
    """`40 s`, `12 min`, `2 h 5 min`."""
    minutes = round(seconds / 60)
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"
