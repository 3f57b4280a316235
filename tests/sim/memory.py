"""What a process occupies."""

from __future__ import annotations

import os
from pathlib import Path

import pytest


def resident_kb() -> float:
    """Resident memory of this process (kB). Skips the test on systems without /proc."""
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    except OSError:
        pytest.skip("the memory of a process is in /proc only on Linux")
    return pages * os.sysconf("SC_PAGE_SIZE") / 1000
