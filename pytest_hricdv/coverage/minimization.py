"""Minimization: a minimal suite with the coverage of all tests, and what each test adds."""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class MeasuredTest:
    """A test, the points that it covers (a bit set), and what it costs (s of simulated time)."""

    name: str
    points: int
    cost_s: float


@dataclass(frozen=True)
class Step:
    """A test of the minimal suite: points it adds to the tests before it; points and cost of all up to it."""

    name: str
    gain: int
    points: int
    cost_s: float


def minimal_suite(tests: Sequence[MeasuredTest]) -> tuple[Step, ...]:
    """A small part of the tests that covers as much as all of them, those that add most per simulated second first.

    Greedy: within a factor of ln(n) + 1 of the cheapest suite (Chvatal 1979). Tests that later ones made redundant are
    removed again.
    """
    return _ordered(_without_redundant(_greedy(tests)))


def growth(tests: Sequence[MeasuredTest]) -> tuple[tuple[float, int], ...]:
    """What the tests cover together, in their order: (cost up to a test, points) at each test that adds any."""
    covered, cost_s = 0, 0.0
    steps = []
    for test in tests:
        cost_s += test.cost_s
        if test.points & ~covered:
            covered |= test.points
            steps.append((round(cost_s, 6), covered.bit_count()))
    return tuple(steps)


def unique(tests: Sequence[MeasuredTest]) -> dict[str, int]:
    """Name -> how many points no other test covers; tests without such a point are left out."""
    once = twice = 0
    for test in tests:
        twice |= once & test.points
        once |= test.points
    alone = {test.name: (test.points & ~twice).bit_count() for test in tests}
    return {name: count for name, count in alone.items() if count}


def _greedy(tests: Sequence[MeasuredTest]) -> list[MeasuredTest]:
    """Tests that add most per second, until nothing is added. A gain only falls, so a lazy heap re-evaluates few."""
    by_name = {test.name: test for test in tests}
    queue = [(-_rate(test, test.points), test.name) for test in tests if test.points]
    heapq.heapify(queue)
    chosen, covered = [], 0
    while queue:
        _, name = heapq.heappop(queue)
        test = by_name[name]
        added = test.points & ~covered
        if not added:
            continue
        now = (-_rate(test, added), name)
        if queue and queue[0] < now:
            heapq.heappush(queue, now)
            continue
        chosen.append(test)
        covered |= added
    return chosen


def _without_redundant(chosen: Sequence[MeasuredTest]) -> list[MeasuredTest]:
    """Without tests whose points the others cover, tried from the most expensive on."""
    count: Counter[int] = Counter()
    points = {test.name: _bits(test.points) for test in chosen}
    for each in points.values():
        count.update(each)
    kept = []
    for test in sorted(chosen, key=lambda test: (-test.cost_s, test.name)):
        if all(count[point] > 1 for point in points[test.name]):
            count.subtract(points[test.name])
        else:
            kept.append(test)
    return kept


def _ordered(chosen: Sequence[MeasuredTest]) -> tuple[Step, ...]:
    steps: list[Step] = []
    covered, cost_s = 0, 0.0
    for test in _greedy(chosen):
        gain = (test.points & ~covered).bit_count()
        covered |= test.points
        cost_s += test.cost_s
        steps.append(Step(test.name, gain, covered.bit_count(), round(cost_s, 6)))
    return tuple(steps)


def _rate(test: MeasuredTest, points: int) -> float:
    """Points per second; a test that ends at once counts as one second, or its rate would be infinite."""
    return points.bit_count() / max(test.cost_s, 1.0)


def _bits(points: int) -> list[int]:
    text = bin(points)[:1:-1]
    return [place for place, digit in enumerate(text) if digit == "1"]
