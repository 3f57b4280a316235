"""Groups of a testbench's optional fields, each a frozen dataclass with defaults."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from pytest_hricdv._base.suggestion import nearest
from pytest_hricdv.runtime.blocking_calls import KINDS

ENDINGS = ("limit", "idle", "early", "cycle")
"""What `VirtualTime.allowed_endings` may name."""


@dataclass(frozen=True)
class VirtualTime:
    """How the code under test waits, and how its runs may end.

    Args:
        apis: the blocking APIs that the code under test uses: "time" (`time` and `datetime`), "threading" (`threading`,
            `queue`, the thread pool of `concurrent.futures`), "asyncio". Its modules see them in virtual time, and its
            threads are nodes. A wait in any other one is an error.
        stall_timeout_s: processor time for which code may work without simulated time passing (s; None: 8). A second
            of simulated time may take 7.5 times as long. After that, the run ends, and names the line of that code.
        allowed_endings: how a run may end other than by `kernel.stop`; any other ending fails its test: "limit" (at its
            time limit), "idle" (nothing is left to do), "early" (the code under test returns before the run ends),
            "cycle" (a livelock: the run repeats itself for 180 s, and ends unless "cycle" or "limit" is allowed).
    """

    apis: tuple[str, ...] = ()
    stall_timeout_s: float | None = None
    allowed_endings: tuple[str, ...] = ()

    def faults(self) -> Iterator[str]:
        """What is wrong with it."""
        for name in self.apis if isinstance(self.apis, tuple) else (self.apis,):
            if name not in KINDS:
                listed = "; ".join(f'"{api}" for {modules}' for api, modules in KINDS.items())
                yield f"time: apis has {name!r}; expected a tuple of these: {listed}"
        timeout_s = self.stall_timeout_s
        is_time = isinstance(timeout_s, int | float) and not isinstance(timeout_s, bool)
        if timeout_s is not None and not (is_time and 0 < timeout_s < math.inf):
            yield f"time: stall_timeout_s is {timeout_s!r}; expected a time in seconds, above 0"
        endings = self.allowed_endings
        for ending in endings if isinstance(endings, tuple) else (endings,):
            if ending not in ENDINGS:
                expected = f"expected of {', '.join(ENDINGS)}{nearest(ending, ENDINGS)}"
                yield f"time: allowed_endings has {ending!r}; {expected}"
