"""The original's runs, as far as they are given: half of its tests, with what came of each."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from benchmarks.agreement.asked import Asked, asked

FILE = Path(__file__).with_name("original_runs.json")
REQUIREMENTS = ("R1", "R2", "R3")


@dataclass(frozen=True)
class OriginalRun:
    """One run of the original.

    Args:
        suite: whose test it is.
        number: of the test in its suite.
        lines: the test's commands.
        coverage: statements of the original code that it covered (%).
        verdicts: of R1 to R3.
        legs: how each turn ended; None where that is not given.
    """

    suite: str
    number: int
    lines: tuple[str, ...]
    coverage: float
    verdicts: Mapping[str, str] = field(hash=False)
    legs: tuple[str, ...] | None

    @property
    def name(self) -> str:
        """What the test is called when it is read from the file as a suite."""
        return f"{self.suite} {self.number}"

    @cached_property
    def asked(self) -> tuple[Asked, ...]:
        """What it asks for."""
        return asked(self.lines)


def runs() -> tuple[OriginalRun, ...]:
    """All runs whose commands were recorded."""
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


def method(suite: str) -> str:
    """The method of a suite: the original drew at random from beliefs in three goes."""
    return "bdi-random" if suite.startswith("bdi-random") else suite
