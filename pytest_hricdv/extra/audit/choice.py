"""Which tests run again: failures first, then of each way to end one, the longest way first."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from itertools import zip_longest

from pytest_hricdv.results.model import TestResult

LEAST = 3
"""So many tests run again in any session, however short. Chosen: `python -m benchmarks.isolation` measures what they
cost."""

PERCENT = 3.0
"""Or more, as long as the time that they took in the session is no more than this share of all tests' time. Chosen: a
session should not notice it; what other shares find was not measured."""


def chosen(results: Sequence[TestResult], place: Mapping[str, int], number: int | None) -> list[TestResult]:
    """The tests to run again, in order.

    Args:
        results: of the session's tests.
        place: node id -> how many tests ran before it in its process; those that did not run in this session have none.
        number: so many; None: `LEAST`, or `PERCENT` of the time.
    """
    ways: dict[tuple[object, ...], list[TestResult]] = defaultdict(list)
    for result in results:
        if result.nodeid in place and result.outcome != "not-run":
            ways[(not result.fails, result.outcome, result.ended, result.outcomes)].append(result)
    # What ran late in its process has the most before it that may have left something.
    lists = [sorted(group, key=lambda result: (-place[result.nodeid], result.id)) for group in ways.values()]
    lists.sort(key=lambda group: -sum(result.sim_s for result in group) / len(group))
    failing = [group for group in lists if group[0].fails]
    others = [group for group in lists if not group[0].fails]
    order = [*_in_turn(failing), *_in_turn(others)]
    if number is not None:
        return order[:number]
    budget_s = PERCENT / 100.0 * sum(result.wall_s or 0.0 for result in results)
    taken: list[TestResult] = []
    for result in order:
        budget_s -= result.wall_s or 0.0
        if len(taken) >= LEAST and budget_s < 0.0:
            break
        taken.append(result)
    return taken


def _in_turn(groups: Sequence[Sequence[TestResult]]) -> list[TestResult]:
    """One of each group, then the next of each."""
    return [result for row in zip_longest(*groups) for result in row if result is not None]
