"""The original's runs whose commands are recorded (half of its tests), with their results."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from studies.original.requests import LegRequest, leg_requests

FILE = Path(__file__).with_name("runs.json")
REQUIREMENTS = ("R1", "R2", "R3")


@dataclass(frozen=True)
class OriginalRun:
    """One run of the original.

    Args:
        suite: that the test belongs to.
        number: of the test in its suite.
        lines: the test's commands.
        coverage: statements of the original code that it covered (%).
        verdicts: of R1 to R3.
        legs: how each turn ended; None where that is not recorded.
    """

    suite: str
    number: int
    lines: tuple[str, ...]
    coverage: float
    verdicts: Mapping[str, str] = field(hash=False)
    legs: tuple[str, ...] | None

    @property
    def name(self) -> str:
        """The test's name when the file is read as a suite."""
        return f"{self.suite} {self.number}"

    @cached_property
    def requests(self) -> tuple[LegRequest, ...]:
        """The legs that it asks for."""
        return leg_requests(self.lines)


def load_runs() -> tuple[OriginalRun, ...]:
    """All runs whose commands are recorded."""
    data = json.loads(FILE.read_text(encoding="utf-8"))
    return tuple(
        OriginalRun(
            suite=suite,
            number=entry["n"],
            lines=tuple(entry["steps"]),
            coverage=float(entry["coverage"]),
            verdicts={name: entry[name] for name in REQUIREMENTS},
            legs=None if entry.get("legs") is None else tuple(entry["legs"]),
        )
        for suite, entries in data.items()
        for entry in entries
        if entry["steps"] is not None
    )


def method_of(suite: str) -> str:
    """The method of a suite: the original drew its random belief sets in three suites."""
    return "bdi-random" if suite.startswith("bdi-random") else suite
