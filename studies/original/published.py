"""What the paper and the original experiment's data say.

Araiza-Illan, Pipe, Eder: Intelligent Agent-Based Stimulation for Testing Robotic Software in Human-Robot Interactions.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

HOUR_S = 3600.0
RUN_S = (100.0, 175.0)
"""A logged run took this long in real time, shortest and longest."""
LEARNING_S = 3 * HOUR_S
LEARNING_ITERATIONS = 300
TOLERANCE = 1e-4
"""Learning stopped when no cell of Q changed by more."""


@dataclass(frozen=True)
class Published:
    """A method's figures.

    Args:
        title: what the paper calls it.
        tests: how many.
        verdicts: requirement -> passed, failed, not checked.
        mean: of the coverage per test, % of statements.
        most: of the same.
    """

    title: str
    tests: int
    verdicts: Mapping[str, tuple[int, int, int]]
    mean: float
    most: float


METHODS: Mapping[str, Published] = {
    "by-hand": Published(
        "BDI by hand",
        138,
        {"R1": (90, 1, 47), "R2": (100, 0, 38), "R3": (138, 12, 0), "R4": (138, 0, 0)},
        87.0,
        91.0,
    ),
    "bdi-random": Published(
        "BDI pseudorandom",
        100,
        {"R1": (7, 0, 93), "R2": (73, 0, 27), "R3": (89, 10, 1), "R4": (100, 0, 0)},
        76.0,
        90.0,
    ),
    "rl": Published(
        "BDI RL",
        134,
        {"R1": (24, 0, 110), "R2": (94, 0, 40), "R3": (121, 11, 2), "R4": (134, 0, 0)},
        74.0,
        91.0,
    ),
    "pseudorandom": Published(
        "pseudorandom",
        100,
        {"R1": (1, 0, 99), "R2": (18, 0, 82), "R3": (16, 20, 64), "R4": (100, 0, 0)},
        70.0,
        75.0,
    ),
}
"""R3 by hand is as printed: it adds up to 150 of 138 tests."""
