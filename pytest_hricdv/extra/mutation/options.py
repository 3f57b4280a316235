"""The options of mutation testing: how mutants are tried."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class MutationOptions:
    """How mutants are tried.

    Args:
        asked: whether they are.
        tests: maximum number of tests of each suite; None: all.
        mutants: maximum number of mutants; None: all.
        seconds: none is begun later; None: no limit.
        matrix: whether to try more tests after one has failed.
    """

    asked: bool = False
    tests: int | None = 10
    mutants: int | None = None
    seconds: int | None = None
    matrix: bool = False
