"""The options of mutation testing, `--hri-mutate` and others."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class MutationOptions:
    """How mutants are tried.

    Args:
        asked: whether mutants are tried (`--hri-mutate`).
        tests: maximum number of tests of each suite that a mutant is tried on; None: all.
        mutants: maximum number of mutants; None: all.
        seconds: no mutant is begun later; None: no limit.
        matrix: whether to try more tests on a mutant after one has failed.
    """

    asked: bool = False
    tests: int | None = 10
    mutants: int | None = None
    seconds: int | None = None
    matrix: bool = False
