"""A suite as a session runs it."""

from __future__ import annotations

from dataclasses import dataclass

from pytest_hricdv.generate.suite import Suite


@dataclass(frozen=True)
class Selected:
    """A suite with what generating it took (s of wall time; 0 and `cached` when it came from the cache)."""

    suite: Suite
    wall_s: float
    cached: bool
