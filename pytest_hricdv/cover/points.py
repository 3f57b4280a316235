"""Coverage points: all that a test can cover, each a bit, so that sets of tests are compared with `|` and `&`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from pytest_hricdv.cover.listing import bits_of

Point = tuple[str, ...]
"""What it is ("plan", "bin", "verdict"), and its names."""


class Points:
    """Numbers the points of a report's tests.

    Statements and branches come first, with the numbers that they have in tests' bits. Plans, bins of cross products
    (legal ones) and verdicts of requirements (Passed, Failed) follow as they are met.

    Args:
        statements: how many statements the code has.
        branches: how many branches.
        illegal: bins that are none to cover, by cross product.
    """

    def __init__(self, statements: int, branches: int, illegal: Mapping[str, Iterable[Iterable[str]]]) -> None:
        self._statements = statements
        self._first = statements + branches
        self._illegal = {name: {tuple(each) for each in bins} for name, bins in illegal.items()}
        self._numbers: dict[Point, int] = {}

    def of(self, runs: Iterable[Mapping[str, Any]]) -> int:
        """The points that any of these runs of a test covers, as a bit set."""
        covered = 0
        for run in runs:
            bits = bits_of(run["code"])
            if bits is not None:
                covered |= bits.statements | (bits.branches or 0) << self._statements
            for point in self._named(run):
                covered |= 1 << self._first + self._numbers.setdefault(point, len(self._numbers))
        return covered

    def _named(self, run: Mapping[str, Any]) -> Iterable[Point]:
        for agent, labels in run["plans"].items():
            yield from (("plan", agent, label) for label in labels)
        for name, hits in run.get("cross", {}).items():
            illegal = self._illegal.get(name, set())
            yield from (("bin", name, *hit) for hit in hits if tuple(hit) not in illegal)
        for requirement, verdict in run["requirements"].items():
            if verdict["verdict"] != "NC":
                yield "verdict", requirement, verdict["verdict"]
