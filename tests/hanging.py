"""That something ends at all: what never does, or grows with the square of its input, takes minutes in these tests."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator

# Far above what any of it takes (below 4 s on the slowest machine so far), far below what a square costs here.
HANGING_S = 60.0


@contextlib.contextmanager
def ends() -> Iterator[None]:
    """What runs inside takes less than ``HANGING_S`` of processor time, whatever else the machine does."""
    began_s = time.process_time()
    yield
    assert time.process_time() - began_s < HANGING_S
